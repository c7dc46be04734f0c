"""The network link: sockets, keys, packet filter, and session state.

Sites use `link`, `packet_filter`, `session_state`, `local_control` and `emergency_stop`. `link_sides` is the
interface for other transports.
"""
