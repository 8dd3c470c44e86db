import flexmech

study = flexmech.study_composites()
print(study.summary())
study.plot().savefig("frequencies_by_laminate.png")
