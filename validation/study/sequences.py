"""Study of sequences: animations through every format, tangled starts, speed, and memory.

`python -m validation study sequences` starts it. Each part is a file beside this one.
"""

from validation.study.parts import Part
from validation.study.sequence_formats import formats
from validation.study.sequence_memory import memory
from validation.study.sequence_speed import speed
from validation.study.sequence_tangles import tangled

PARTS: dict[str, Part] = {
    "formats": formats,
    "tangles": tangled,
    "speed": speed,
    "memory": memory,
}
