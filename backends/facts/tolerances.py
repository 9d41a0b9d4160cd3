"""The constants of the facts and of the checks that read them, with units and reasons (docs/facts.md lists them)."""

from __future__ import annotations


class Tolerance(float):
    """Number with its unit and the reason for its value.

    Examples
    --------
    >>> width = Tolerance(0.05, "of the body's breadth", "thinner feet are edges")
    >>> 2.0 * width, width.unit
    (0.1, "of the body's breadth")
    """

    unit: str
    reason: str

    def __new__(cls, value: float, unit: str, reason: str) -> Tolerance:
        number = super().__new__(cls, value)
        number.unit, number.reason = unit, reason
        return number


# --- contacts ---
TOUCH_OF_SOLIDS = Tolerance(
    0.02, "of the smaller solid's diagonal", "small objects in a large scene are placed as exactly as large ones"
)
SHALLOW = Tolerance(
    0.05, "of a solid's extent along the separation", "overlaps up to this close the seams of a model; deeper ones show"
)
SEAM = Tolerance(
    0.1,
    "of a body's extent along the separation",
    "a shape without a word runs this far into its neighbors: walls into towers, rods into beams (all 5 false overlaps "
    "of 122 sound scenes, and none of 25 faults), and two buildings, of which each does: a note",
)
SET_IN = Tolerance(
    0.05, "of the upper body's longest side", "the depth from which an enclosed foot holds its body, as a peg does"
)
BURIED = Tolerance(0.25, "of a body's height", "what is this deep in another is built into it")
UPRIGHT = Tolerance(
    0.8, "vertical component of a contact's normal", "slopes up to 37 degrees; steeper contacts are sideways"
)

# --- bodies ---
MAIN_CLUSTER = Tolerance(
    0.5, "of the solids of an entity", "an entity is one body if this part of it touches; else it is an arrangement"
)

# --- ground ---
GROUND_AREA = Tolerance(
    0.5, "of the scene's area", "floors, lawns and plates carry most of a scene; rugs and table tops do not"
)
GROUND_FLATNESS = Tolerance(
    0.5, "of its shorter side", "the ground is flat: at most this high; a pedestal is an object"
)
GROUND_MARGIN = Tolerance(
    1.1, "times the broadest solid on it", "a brick under a brick is an object; floors and plates are broader"
)
TERRAIN_AREA = Tolerance(0.9, "of the scene's area", "the ground below all others may have hills and valleys")
GROUND_BELOW = Tolerance(0.1, "of the solids", "more of them below a broad body are its legs: it is a table")
WALL_SPAN = Tolerance(
    0.6, "of two extents of the scene", "a panel that closes a scene off stands by construction, not by its weight"
)
WALL_THICKNESS = Tolerance(0.1, "of its shorter side", "a panel is thin")

# --- statics ---
FRICTION = Tolerance(
    0.6, "coefficient of friction", "of bodies without `:friction`; wood on wood has .25 to .6, rubber more"
)
BALANCE = Tolerance(
    0.01, "of a body's breadth", "a body bears this shift of its center of mass, or it stands on an edge"
)
NARROW = Tolerance(
    0.05, "of a body's breadth", "a body with less balance may move in a simulation, whose contacts give way: a note"
)
HEAVY_FOOT = Tolerance(
    5.0, "times its density", "lamps and stands have heavy feet and hollow tops; a body that tips even so is a warning"
)
PARALLEL = Tolerance(
    0.9995, "cosine", "two opposed faces within 1.8 degrees clamp: friction between them is not counted, since nothing "
    "presses them together",
)  # fmt: skip
MOUNT_DEPTH = Tolerance(1.0 / 3.0, "of a body's breadth", "what stands out from a wall by at most this is hung there")
MOUNT_AREA = Tolerance(0.5, "of its back", "the part of a mounted body's back that touches the wall")
SUSPENSION_HEIGHT = Tolerance(0.1, "of a body's height", "what is held in its top tenth hangs, as a lamp from its cord")
SUSPENSION_AREA = Tolerance(0.05, "of its footprint", "a hanging body is held at a point rather than a face")
LINE = Tolerance(
    20.0, "length over breadth", "ropes, cords and wires hold by an upper end that touches a side, such as a drum's"
)
GLUED_AREA = Tolerance(
    1.0 / 3.0, "of its side", "a face contact that could be glue: arms of a robot; what falls without it is a note"
)
HINGE_SPAN = Tolerance(
    1.0 / 3.0,
    "of a body's height",
    "two contacts at a side this far apart could be hinges; what falls without is a note",
)

BRACKET_SPAN = Tolerance(
    0.5, "of a body's breadth", "contacts at a side this far apart could be screws, a bar or a magnet: a note"
)
SMALL_BASE = Tolerance(
    0.25, "of the scene's area", "an object around the origin whose lowest parts cover less does not stand on them"
)
NEARLY = Tolerance(
    0.03,
    "of a body's breadth",
    "a center of mass this little beyond the support is on its edge by rounding: a note",
)

# --- checks ---
CONTACT_ERROR = Tolerance(2.0, "contact tolerances", "overlaps up to this are errors of round surfaces and of rounding")
SUNK_BASE = Tolerance(0.02, "of a body's height", "how deep a flat base may be in the ground or on what it stands")
SLIM = Tolerance(4.0, "height over breadth of the foot", "stems and posts are planted, and tables are not")
PLANTED = Tolerance(
    0.2, "of a leg's length", "posts are planted by up to a fifth of their length; furniture sinks by more, or alone"
)
COPLANAR_AREA = Tolerance(0.005, "of the scene's largest side", "smaller faces that flicker are hardly seen: a note")
SOFT = Tolerance(
    1.0 / 3.0,
    "of the smaller round solid's diagonal",
    "crowns and cushions meet so; deeper ones share a place",
)
EDGE_AREA = Tolerance(
    0.25, "of a solid's largest side", "boards that end flush with their back share narrow edges, labels their faces"
)
HIGH = Tolerance(
    0.5, "of the height of what stands", "suns and birds are this far above everything, and by their own height; a "
    "cup that floats over its table is not",
)  # fmt: skip
DETOUR = Tolerance(
    6.0,
    "times the shortest distance",
    "what floats is put where it belongs: a knob on its door, .06 away, not on the floor, 1 below; a chair .3 beside a "
    "table may drop by 1.4",
)
SNOW_COUNT = Tolerance(8, "equal bodies", "many equal small bodies in the air are meant: snow, sparks, leaves")
SNOW_SIZE = Tolerance(0.02, "of the scene's diagonal", "the size of such bodies")
JOINT = Tolerance(0.25, "of a body's extent", "the gap between slats, planks and tiles of one row")
COURSE = Tolerance(0.1, "of a body's height", "the joint between courses of bricks and drums of a column")
CAGE_SIDES = Tolerance(3, "sides", "a body enclosed on so many sides is in a case, as a drawer")
CAGE_OVERLAP = Tolerance(0.25, "of each extent", "a drawer that is pulled out half is still held by its case")
CAGE_DROP = Tolerance(0.1, "of a body's height", "the drop of a caged body that is clearance rather than a gap")

# --- repair: weights of the way that an edit moves objects, against 1 for the shortest way that resolves a finding ---
SIBLING_SLIP = Tolerance(
    0.5,
    "of the way",
    "what a form of the same word has there also reaches a contact: hardly by chance (12 of 13 repairs)",
)
OTHER_SLIP = Tolerance(1.5, "of the way", "what a form of another word has there is the height of many things")
SIGN_SLIP = Tolerance(1.0, "of the way", "scenes are symmetric, so that the other side often has room too")
TURN_SLIP = Tolerance(0.5, "of the way", "few angles are written, and a ladder leans on nothing by chance")
ZERO_SLIP = Tolerance(0.8, "of the way", "crowns, roofs and lids are on the axis of what carries them")
POINT_SLIP = Tolerance(
    0.1,
    "of the way",
    "ten times a number with more decimals than nine tenths of its program: .105 for 1.05, .016 for .16",
)
ORDER_SLIP = Tolerance(1.5, "of the way", "two components exchanged, x and z or one with 0, move a thing far")
LOOSE_SLIP = Tolerance(2.0, "of the way", "where only room is needed, siblings and zeros make it by chance")
DEEPER = Tolerance(1.5, "times the way", "a lamp's hook may go into its arm, if what is not deeper is farther")
GLUED = Tolerance(3.0, "times the way", "the head of a snowman stands on its chest only if the balls are joined")
AROUND = Tolerance(0.1, "of an object's size", "what is this near may be what is wrong instead: a post, a bracket")
