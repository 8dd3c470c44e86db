import flexmech

parts = flexmech.published_constituents()
ply = flexmech.ply_from_constituents(parts["carbon"], parts["polyester"], 0.6, "rule-of-mixtures")
stack = flexmech.Laminate.stacked([ply] * 5, thickness=1e-3, angles=[0.0] * 5)
section = flexmech.BeamSection.of_laminate(flexmech.LaminateSection(stack, width=25e-3))
linkage = flexmech.FourBar(ground=0.4, crank=0.1, coupler=0.35, rocker=0.2)
mechanism = flexmech.Mechanism(linkage, dict.fromkeys(("crank", "coupler", "rocker"), section))
print(flexmech.natural_frequencies(flexmech.ReferenceEngine(mechanism), 0.0))
