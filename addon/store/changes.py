"""What happens when something that is kept changes: the store itself calls nobody above it; `handlers` wires them."""

from collections.abc import Callable

__all__ = ["LIGHT_GROUP_RENAMED", "MIX", "PASSES", "WIPE", "follow", "forget", "tell"]

MIX = "mix"  # (scene): what the picture is made of
LIGHT_GROUP_RENAMED = "light group renamed"  # (scene, before, after) -> the name that it got
PASSES = "passes"  # (scene): what is rendered, and has to be set up afresh
WIPE = "wipe"  # (scene, position): where a comparison is divided

_followers: dict[str, Callable] = {}


def follow(change: str, function: Callable) -> None:
    """Call `function` at each change of that kind from now on, with the arguments listed above."""
    _followers[change] = function


def forget() -> None:
    """Call nothing from now on."""
    _followers.clear()


def tell(change: str, *about) -> object:
    """Call the function that follows that change and return what it returns; None where there is none."""
    follower = _followers.get(change)
    return follower(*about) if follower else None
