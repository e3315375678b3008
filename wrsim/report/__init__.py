"""What people keep of results: folders of runs, tables and pictures, pages for a browser that need nothing else.
Everything in a page that comes from users (titles, names, paths, scenario texts) is escaped."""
