"""The impacts that a detector knows, and keeps from one path to the next."""

from collections.abc import Sequence

import numpy as np

from izo_ref.base.arrays import Floats, Indices, Positions
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.records import Impacts, Pairs, join_impacts, no_impacts
from izo_ref.detection.cpu import frames as kernels
from izo_ref.detection.doubts import settle_doubts
from izo_ref.detection.near_pairs import Contacts
from izo_ref.detection.pair_keys import pair_keys
from izo_ref.detection.serial.reach import largest_moves


class KnownImpacts:
    """The impacts of a path, sorted by their kind and their elements.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], start of every path.
        start_is_free: Whether the start is known to be free; pairs at rest are then no impacts.
        excluded: Keys of the pairs to ignore, as `pair_keys` makes them, or None.
        deadline: When each call has to end.

    Attributes:
        impacts: `Impacts`.
    """

    def __init__(
        self,
        positions_t0: Positions,
        start_is_free: bool,
        excluded: set[bytes] | None,
        deadline: Deadline = UNLIMITED,
    ) -> None:
        """Begin without any impact."""
        self.impacts = no_impacts()
        self._positions_t0, self._start_is_free = positions_t0, start_is_free
        self._excluded, self._deadline = excluded, deadline
        self._keys: Indices = np.empty(0, np.int64)  # by which the impacts are sorted

    def forget(self, moves: Floats) -> None:
        """Forget the impacts of vertices that moved.

        Args:
            moves: (n_vertices,) f8 [m], 0 for vertices that did not move.
        """
        if len(self._keys) == 0:
            return
        still = ~(moves.take(self.impacts.nodes) > 0.0).any(axis=1)
        if not still.all():
            self._keys, self.impacts = self._keys[still], self.impacts.take(still)

    def add(self, contacts: Sequence[Contacts], positions_t1: Positions) -> None:
        """Add the impacts among some contacts.

        Args:
            contacts: Contacts of pairs that are not known as impacts.
            positions_t1: (n_vertices, 3) f8 [m], ends of the path.
        """
        if not any(len(part.keys) for part in contacts):
            return
        joined = Contacts._make([np.concatenate(parts) for parts in zip(*contacts, strict=True)])
        keys, found = self._impacts_of(joined, positions_t1)
        keys = np.concatenate((self._keys, keys))
        order = np.argsort(keys)
        self._keys = keys.take(order)
        self.impacts = join_impacts((self.impacts, found)).take(order)

    def _impacts_of(self, contacts: Contacts, positions_t1: Positions) -> tuple[Indices, Impacts]:
        """Return the impacts among some contacts, and their keys."""
        moving = largest_moves(positions_t1, self._positions_t0)[0] > 0.0
        if self._start_is_free and not moving.all():
            contacts = contacts.take(moving.take(contacts.nodes).any(axis=1))
        if self._excluded is not None:
            named = pair_keys(Pairs(contacts.nodes, contacts.keys >= 0))
            kept = np.array([key not in self._excluded for key in named], bool)
            contacts = contacts.take(kept)
        if self._start_is_free and not contacts.toi.all():
            ends = self._positions_t0, positions_t1
            _, nodes, toi, directions = contacts
            kinds = contacts.keys >= 0
            meets = settle_doubts(*ends, nodes, kinds, toi, directions, self._deadline)
            contacts = contacts.take(meets)
        keys, nodes, toi, directions = contacts
        kinds, weights, normals = keys >= 0, np.empty((len(keys), 4)), np.empty((len(keys), 3))
        kernels.compute_impact_frames(
            self._positions_t0, positions_t1, nodes, kinds, toi, directions, weights, normals
        )
        return keys, Impacts(nodes, kinds, toi, weights, normals)
