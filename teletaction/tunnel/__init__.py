"""Carries the link of two sites over a rendezvous, where neither can connect to the other.

Commands use `rendezvous` and `tunnel_end`. Sites do not know of it: the link is encrypted from site to site.
"""
