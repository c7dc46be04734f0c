"""The loop of a site, its priority, its watchdog, and the containment of failing steps.

Sites use `site_loop` and `containment`.
"""
