"""Links in the state of stress of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.links.chains import in_positions
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import RigidMotion


@dataclass(frozen=True)
class StressedLinks:
    """Tangent stiffness, damping and forces of each link in a state of stress.

    The internal force of a link near that state is
    ``internal_force + tangent @ (q - displacement)``, all in its link frame.

    Parameters
    ----------
    tangent : list of ndarray, shape (n, n) or (B, n, n)
    displacement : list of ndarray, shape (B, n), or None
        Displacement of the state; None for links taken as straight.
    internal_force : list of ndarray, shape (B, n), or None
        Internal force of the state; None for straight links, where there is none, and
        where an engine does not provide it.
    damping : list of ndarray, shape (B, n, n), or None
        Damping matrix in the state; None for that of the straight links. A bowed link that
        bends further is not stretched along its axis, and must not be damped as if it were.
    loads : list of ndarray, shape (B, n), or None
        Forces on the links in the state; None where there are none, or an engine does not
        provide them.
    guide_stiffness : ndarray, shape (B, n_sliders), or None
        Geometric stiffness between the rotation of a slider's guide and its slide in N/rad.
    unstressed : bool
        Whether the tangents are the links' own stiffness, those of designs as they are.
    motion : RigidMotion, or None
        Of the linkage in these positions, a batch of shape (B,); None where it is not kept.
    """

    tangent: Sequence[FloatArray]
    displacement: list[FloatArray] | None = None
    internal_force: list[FloatArray] | None = None
    damping: Sequence[FloatArray] | None = None
    loads: list[FloatArray] | None = None
    guide_stiffness: FloatArray | None = None
    unstressed: bool = False
    motion: RigidMotion | None = None

    @classmethod
    def unloaded(cls, links: Sequence[LinkModel]) -> Self:
        """Straight links without stress."""
        return cls([link.stiffness for link in links], unstressed=True)

    def at(self, which: slice | IntArray) -> Self:
        """Links in chosen positions of the batch, which may be repeated.

        Parameters
        ----------
        which : slice or ndarray of int
        """
        motion = self.motion and self.motion.at(which)
        if self.unstressed:
            return replace(self, motion=motion)

        def chosen(values: list[FloatArray] | None) -> list[FloatArray] | None:
            return None if values is None else [v[which] for v in values]

        return replace(
            self,
            tangent=[in_positions(t, which) for t in self.tangent],
            displacement=chosen(self.displacement),
            internal_force=chosen(self.internal_force),
            damping=self.damping and [d[which] for d in self.damping],
            loads=chosen(self.loads),
            guide_stiffness=None if self.guide_stiffness is None else self.guide_stiffness[which],
            motion=motion,
        )
