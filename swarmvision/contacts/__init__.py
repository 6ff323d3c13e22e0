"""Many worlds' bodies at once, pushed apart where they touch: a contact model without pymunk.

Motion and traction are :mod:`swarmvision.world`'s, in the same order; without contacts the two agree to
rounding when their substeps are equal. Contacts are simpler: robots meet each other and things as discs
of their own area, walls as the boxes that they are. Impulses are found by a few rounds over
all contacts (sequential impulses with Coulomb friction, as in Chipmunk, without warm starts and without
bounce), and what still overlaps is moved apart a little in every substep, at Chipmunk's rate.
"""

from swarmvision.contacts.rows import advance
from swarmvision.contacts.shapes import WALLS, bounds_of, shapes_of

__all__ = ["WALLS", "advance", "bounds_of", "shapes_of"]
