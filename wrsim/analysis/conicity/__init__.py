"""Rolling radius difference and equivalent conicity."""
