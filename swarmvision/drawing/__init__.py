"""A run as pictures: top view, camera mosaic, plots, video."""
