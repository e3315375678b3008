"""wrsim: railway wheelsets on curved track with conformal wheel-rail contact."""

__version__ = "0.1.0"
