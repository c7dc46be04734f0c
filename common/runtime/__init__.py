"""The loop of a site, its priority, its watchdog, and what a failing step leaves behind.

Sites use `site_loop` and `containment`. The others are parts of these.
"""
