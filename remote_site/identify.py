"""Off-line identification of recorded touches and strokes."""

from remote_site.identify_texture import identify_texture
from remote_site.identify_thermal import identify_thermal

__all__ = ["identify_texture", "identify_thermal"]
