"""What an engine derives from, in the words of coupler/link/engine.h."""
from __future__ import annotations

from typing import Any, Iterable, NoReturn, Sequence

from .messages import exchange

BAD_INPUT, PEER_LOST, ENGINE_FAILED = 2, 3, 4  # exit statuses (rigid/README.md)
MOTION = ("position", "orientation", "velocity", "angular_momentum")


class Refused(Exception):
    """Ends the session: the shell process is told kind, message and the id of the `body` that it is about (0: of none), and this
    process ends with `status`."""

    def __init__(self, kind: str, message: str, status: int = PEER_LOST, body: int = 0) -> None:
        super().__init__(message)
        self.kind, self.status, self.body = kind, status, body


class Engine:
    """Holds rigid bodies and takes them through windows. Arguments are messages of proto/exchange.proto, and checked.

    A session calls only what `capabilities` declare: joints needs add_joint, release_joints release_joint, export_rows
    rows, save_restore save and restore.
    """
    name = "engine"
    version = "1"
    capabilities: Sequence[str] = ()

    def add(self, body: Any) -> None:
        """Adds a RigidBody, whose shape is among the capabilities. Raises Refused (bad_body, BAD_INPUT) where the engine
        cannot hold it."""
        raise NotImplementedError

    def set_contact_laws(self, laws: Sequence[Any]) -> None:
        """Takes the Contact laws of pairs of contact groups. Pairs without one have friction 0.5 and restitution 0."""

    def advance(self, window_s: float, predicted: Sequence[Any], solved: Sequence[int]) -> None:
        """One window of `window_s` seconds. `predicted`: a PredictedState for each body that is not static, by ascending id.
        Contacts and joints of the bodies in `solved` are left out."""
        raise NotImplementedError

    def states(self) -> Iterable[Any]:
        """A BodyState of every body that is not static, by ascending id."""
        raise NotImplementedError

    def add_joint(self, joint: Any) -> None:
        """Adds a Joint between bodies that are held. Raises Refused (bad_joint, BAD_INPUT)."""
        self._lacks("joints")

    def release_joint(self, number: int) -> None:
        """From the next window on this joint does not hold. One that is released already stays so."""
        self._lacks("release_joints")

    def rows(self, window_s: float, motions: Sequence[Any], bodies: Sequence[int]) -> Iterable[Any]:
        """ContactRows that `bodies` may have in the next window, with PredictedStates as in advance(). Nothing moves."""
        self._lacks("export_rows")

    def save(self) -> bytes:
        """What states() does not show."""
        self._lacks("save_restore")

    def restore(self, caches: bytes, motions: Sequence[Any]) -> None:
        """Sets the saved state, and the motion of every body that is not static."""
        self._lacks("save_restore")

    def _lacks(self, what: str) -> NoReturn:
        raise Refused("no_capability", f"{self.name} declares '{what}' and does not have it", BAD_INPUT)

    @staticmethod
    def state_of(body: Any) -> Any:
        """The BodyState in which a RigidBody starts."""
        state = exchange().BodyState(id=body.id, mass=body.mass)
        Engine.move(state, body)
        return state

    @staticmethod
    def move(state: Any, motion: Any) -> None:
        """Sets the motion of a BodyState to that of any message that has one, to the bit."""
        for field in MOTION:
            getattr(state, field).CopyFrom(getattr(motion, field))
