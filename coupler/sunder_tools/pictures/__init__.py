"""Reads the frames of a run and shows them: contact sheet, stills, films, meshes for other tools, the page of the viewer."""
