"""Where wheel and rail meet: outline of the yawed wheel, main points, lobes."""
