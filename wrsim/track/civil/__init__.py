"""Tracks of civil engineers: IFC 4.3, LandXML 1.2 and railML 3, read into and written from one record of a line."""

ENDINGS = (".ifc", ".xml", ".landxml", ".railml")
"""Endings of the names of civil files."""
