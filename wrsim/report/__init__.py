"""Pages for a browser, each one file that needs nothing else: the report of results, and the viewer of one.

Everything that comes from users (titles, names, paths, scenario texts) is escaped: by jinja2 in the templates, by
``svg.element`` in drawings.
"""

from wrsim.report.page import report_page

__all__ = ["report_page"]
