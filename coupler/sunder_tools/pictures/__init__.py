"""Reads the frames of a run and makes contact sheets, stills, films, meshes for other tools, and the viewer's data."""
