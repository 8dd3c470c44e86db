# Which link fails first, and by what factor may the speed rise?
import flexmech

material = flexmech.Material(68.9e9, 2698.0, yield_strength=240e6)
section = flexmech.BeamSection.rectangle(material, 4e-3, 25.4e-3)
linkage = flexmech.FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
links = dict.fromkeys(("crank", "coupler", "rocker"), section)
result = flexmech.strength(flexmech.Mechanism(linkage, links), 190.0, speed_unit="rpm")
print(result.summary())
result.plot().savefig("strength.png")
