"""The network link: sockets, keys, which packets count, and the state of a session.

Sites use `link`, `packet_filter`, `session_state`, `local_control` and `emergency_stop`. `link_sides` is the
interface for other transports.
"""
