"""The patient's stop switch and pain slider as a page on a tablet.

The process is a serial device for the remote site: it reports what the page says, and falls silent where the page does.
"""
