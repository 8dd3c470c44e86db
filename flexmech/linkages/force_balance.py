"""First moments of counterweights that balance the shaking force of a linkage with one coupler.

R. S. Berkof and G. G. Lowen, A New Method for Completely Force Balancing Simple Linkages, Journal
of Engineering for Industry 91 (1969) 21-26: with the loop closed, the first moment of all masses is
a sum of linearly independent vectors that rotate with crank and follower; it stands still where
their coefficients are zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from flexmech.errors import InputError
from flexmech.linkages.link_mass import LinkMass
from flexmech.linkages.topology import LinkEnd, Topology

# Numbers of links, clamps, pins, pivots, sliders and welds.
_FOUR_BAR, _SLIDER_CRANK = (3, 1, 2, 1, 0, 0), (2, 1, 1, 0, 1, 0)
METHOD = "counterweights are found for a four-bar and a slider-crank"


@dataclass(frozen=True)
class TurningLink:
    """A link that rotates about a point of the ground and carries one end of the coupler.

    Parameters
    ----------
    number : int
        In the topology.
    name : str
    end : {"start", "end"}
        Its end at that point, or a hub away from it.
    pivot, pin : float
        Places along the link's frame, in m: of the point of the ground, and of the coupler's pin.
    """

    number: int
    name: str
    end: str
    pivot: float
    pin: float

    @property
    def arm(self) -> float:
        """From the point of the ground to the pin, along the link's frame, in m."""
        return self.pin - self.pivot

    def moment(self, mass: LinkMass) -> complex:
        """First moment of the link about the point of the ground, in its frame, kg m."""
        return complex(mass.moment(1) - mass.moment(0) * self.pivot, mass.moment_across)


@dataclass(frozen=True)
class OneCouplerLinkage:
    """A crank, one coupler, and a follower or a slider on the ground.

    Parameters
    ----------
    crank : TurningLink
    coupler : int
        Number of the coupler in the topology.
    first, second : float
        Places along the coupler's frame of its joints with the crank and with the follower or the
        line, in m.
    follower : TurningLink or None
        None of a slider-crank.
    """

    crank: TurningLink
    coupler: int
    first: float
    second: float
    follower: TurningLink | None

    @classmethod
    def of(cls, topology: Topology) -> Self:
        """Crank, coupler and follower of a linkage.

        Parameters
        ----------
        topology : Topology

        Returns
        -------
        OneCouplerLinkage

        Raises
        ------
        InputError
            If it is neither a four-bar nor a slider-crank; says what it has.
        """
        clamps, pivots, sliders = topology.clamps, topology.pivots, topology.sliders
        parts = {
            "link": topology.links,
            "clamp": clamps,
            "pin": topology.pins,
            "pivot": pivots,
            "slider": sliders,
            "weld": topology.welds,
        }
        counts = {name: len(each) for name, each in parts.items()}
        told = (f"{n} {name}{'s' * (n > 1)}" for name, n in counts.items() if n)
        refusal = InputError(
            f"{METHOD}, whose loop has one coupler; this linkage has {', '.join(told)}: the "
            "vectors that would have to vanish are others"
        )
        if tuple(counts.values()) not in (_FOUR_BAR, _SLIDER_CRANK):
            raise refusal
        if any(slider.guide for slider in sliders):
            raise refusal
        joined = _joined(topology)
        fixed = clamps[0].link_end
        pin = _other(fixed)
        if pin not in joined:
            raise refusal
        crank = _turning(topology, fixed, clamps[0].hub)
        first = joined[pin]
        last = _other(first)
        if sliders:
            if sliders[0].link_end != last:
                raise refusal
            follower = None
        else:
            if last not in joined or joined[last] != _other(pivots[0].link_end):
                raise refusal
            follower = _turning(topology, pivots[0].link_end)
        coupler, place = topology.end_place(first)
        return cls(crank, coupler, place, topology.end_place(last)[1], follower)

    @property
    def turning(self) -> tuple[TurningLink, ...]:
        """Links that can carry a counterweight."""
        return (self.crank,) if self.follower is None else (self.crank, self.follower)

    def coupler_masses(self, masses: Sequence[LinkMass]) -> tuple[complex, complex]:
        """Masses at the coupler's two joints that have its mass and its first moment, in kg.

        Parameters
        ----------
        masses : sequence of LinkMass
            One a link, in order.

        Returns
        -------
        tuple of complex
            At the crank and at the follower or the line. Imaginary parts are those of a centre of
            mass off the line between the joints.
        """
        own = masses[self.coupler]
        about = complex(own.moment(1) - own.moment(0) * self.first, own.moment_across)
        second = about / (self.second - self.first)
        return own.moment(0) - second, second

    def balancing_moments(
        self, masses: Sequence[LinkMass], share: float = 1.0
    ) -> tuple[complex, ...]:
        """First moments that counterweights must have, about the points of the ground.

        Parameters
        ----------
        masses : sequence of LinkMass
            One a link, in order.
        share : float
            Of a slider-crank: part of the reciprocating mass that the crank's counterweight
            balances as if it rotated with the pin.

        Returns
        -------
        tuple of complex
            Of each turning link, along and across its frame in kg m. With them nothing of a
            four-bar's shaking force by inertia is left; of a slider-crank's that of the
            reciprocating mass and of the counterweight's share against it.
        """
        first, second = self.coupler_masses(masses)
        loads = [first + share * second] if self.follower is None else [first, second]
        return tuple(
            -(link.moment(masses[link.number]) + load * link.arm)
            for link, load in zip(self.turning, loads, strict=True)
        )


def _other(end: LinkEnd) -> LinkEnd:
    return LinkEnd(end.link, "end" if end.end == "start" else "start")


def _joined(topology: Topology) -> dict[LinkEnd, LinkEnd]:
    """The end that each pinned end is pinned to."""
    pairs = [(pin.leader, pin.follower) for pin in topology.pins]
    return dict(pairs) | {second: first for first, second in pairs}


def _turning(topology: Topology, fixed: LinkEnd, hub: float = 0.0) -> TurningLink:
    number, place = topology.end_place(fixed)
    pin = topology.end_place(_other(fixed))[1]
    return TurningLink(number, fixed.link, fixed.end, place - hub, pin)
