import flexmech

sections = flexmech.section_profiles(flexmech.load_mechanism("models/composite_fourbar.toml"))
print(sections.summary())
sections.plot(link="coupler").savefig("coupler.png")
sections.save("results")
