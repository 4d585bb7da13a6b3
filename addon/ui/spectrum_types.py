"""How files of spectra end."""

__all__ = ["EXTENSIONS", "GLOB", "TEXT"]

EXTENSIONS = (".csv", ".spd", ".spdx", ".cgats", ".it8", ".cie", ".ti3")
TEXT = (".txt", ".dat", ".xml")  # too common to be taken from whoever drops them for something else
GLOB = ";".join(f"*{end}" for end in (*EXTENSIONS, *TEXT))
