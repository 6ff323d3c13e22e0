"""Where one marker stands beside another: there the height of what lies between the bands steps.

Within a marker it only bends. The rims of a near one recede steeply, by a sixth of its height in a few
columns, but evenly: what goes on before a place and behind it alike is no step.
"""

from __future__ import annotations

from swarmvision.compiled import leaf
from swarmvision.geometry import FloatArray
from swarmvision.perception.order import median_of, middle_of

COMPARED = 3  # columns before a place and behind it


@leaf
def step_at(heights: FloatArray, start: int, place: int, end: int, spare: FloatArray) -> tuple[float, float]:
    """Return the size of the step just before a place, and the lower of the heights on its two sides (px).

    Args:
        heights: Column by column (px); those of one chain are from start to end.
        start: The chain's first column.
        place: Two columns or more behind start, and one or more before end.
        end: Behind the chain's last column.
        spare: Room for a few numbers.
    """
    first, last = max(place - COMPARED, start), min(place + COMPARED, end)
    if place - first == COMPARED and last - place == COMPARED:
        before = middle_of(heights[first], heights[first + 1], heights[first + 2])
        after = middle_of(heights[place], heights[place + 1], heights[place + 2])
    else:
        before = median_of(heights[first:place], place - first, spare)
        after = median_of(heights[place:last], last - place, spare)
    bend = 0.0
    if last - place > 1:
        inward = (heights[place - 1] - heights[first]) / (place - 1 - first)
        onward = (heights[last - 1] - heights[place]) / (last - 1 - place)
        if inward * onward > 0.0:
            bend = 0.5 * (last - first) * min(abs(inward), abs(onward))
    return abs(after - before) - bend, min(before, after)
