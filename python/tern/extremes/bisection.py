"""The boundary between values that are bounded and values that are not."""

import math


def find(bounded, beyond, is_bounded, runs=5):
    """(last bounded value, first that is not) by halving the ratio; a side that is never met is None."""
    if not is_bounded(bounded):
        return None, bounded
    if is_bounded(beyond):
        return beyond, None
    for _ in range(runs):
        middle = math.sqrt(bounded * beyond)
        if is_bounded(middle):
            bounded = middle
        else:
            beyond = middle
    return bounded, beyond


def text(bounded, beyond):
    """`0.9 .. 1.1`, or what was found on one side only."""
    if bounded is None:
        return f"not bounded at {beyond:.3g} either"
    if beyond is None:
        return f"none up to {bounded:.3g}"
    return f"{bounded:.3g} .. {beyond:.3g}"
