"""Effects that a scene cannot combine, and why."""

# What is refused, beside what, and the reason with what to give instead, in the words of `Scene._effects`. What
# composes through the gap, the operator, the constraint, the traction or a state has no line here.
REFUSED: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("Scene.load on a point contact", ("Scene.lubrication", "Scene.adhesion", "Scene.rolling"),
     "films, adhesion and rolling with hysteresis are of line contacts alone, leave it out, or give a Cylinder"),
    ("Scene.load is an Approach", ("Scene.hardness", "Scene.rolling", "Scene.lubrication", "a change in time"),
     "only a given load is supported there, give a LineLoad"),
    ("Scene.load is a PullOff", ("a change in time",),
     "a scene that changes has a history, give a LoadHistory that falls until contact is lost"),
    ("Scene.load is a PullOff", ("Scene.rolling",),
     "elastic bodies that roll part at the load at which they do at rest, leave rolling out"),
    # hardness, and bodies that yield
    ("Scene.hardness", ("Scene.load that falls", "a contact that rolls", "Scene.wear", "Scene.solids that creep"),
     "a hardness does not remember the dent where pressures fall, give an ElasticPlasticHalfSpace, or leave the "
     "hardness out"),
    ("Scene.hardness", ("Scene.solids that yield",),
     "yielding limits the pressure by itself, leave the hardness out, or give an elastic HalfSpace"),
    ("Scene.hardness", ("Scene.lubrication",),
     "the pressure of a lubricant follows from its flow, which a limit would interrupt, leave the hardness out, and "
     "compare the peak pressure with it"),
    ("Scene.rolling without passes", ("Scene.solids that yield",),
     "plastic strain has a history, give Rolling its passes, or leave rolling out"),
    ("Scene.outputs", ("passes over Scene.solids that yield",),
     "the residual stress is in the answer, leave the outputs out"),
    ("Scene.lubrication", ("Scene.solids that yield",),
     "plastic strain is computed in dry contacts only, give an elastic HalfSpace"),
    ("Scene.friction with stick", ("Scene.solids that yield",),
     "traction makes the body flow along its surface, which is not computed, give a HalfSpace or a CoatedHalfSpace"),
    # friction and rolling
    ("Scene.rolling", ("TractiveRolling",), "the law rolls at its own speed, leave rolling out"),
    ("Scene.rolling", ("Scene.friction in partial slip",),
     "material carries traction through a rolling contact, give TractiveRolling, which has a speed of its own"),
    ("Rolling.passes", ("Sliding", "Scene.wear"),
     "traction and wear of repeated rolling are not computed, leave one of them out"),
    ("Scene.friction in partial slip without times", ("a change in time",),
     "traction depends on the path of its forces, give Fretting.times [s] to its forces"),
    ("Fretting.displacements", ("Scene.load that changes",),
     "the traction locked in by a rising pressure follows from forces only, give Fretting.forces, or a LineLoad"),
    ("Scene.shapes that move with a body", ("Scene.rolling", "TractiveRolling"),
     "heights that travel through the contact make no steady state, give heights that are fixed in its frame"),
    ("Scene.friction in partial slip", ("Scene.solids that are elastically dissimilar",),
     "such bodies slip under the normal load alone, give bodies of one material, or Sliding"),
    ("Scene.friction in sliding of dissimilar bodies", ("Scene.solids that creep",),
     "creep of their coupling is not computed, give equal bodies, or an incompressible one on a rigid one"),
    ("Scene.friction in sliding of dissimilar bodies", ("Scene.rolling",),
     "both make the pressure asymmetric, which is not computed, give bodies of one material, or TractiveRolling"),
    # free faces
    ("Scene.lubrication", ("Scene.solids with free_faces",),
     "a film is computed as periodic along the length, leave it out, or leave free_faces out and give a Crown or a "
     "LundbergProfile"),
    ("Scene.solids with free_faces", ("Scene.solids that creep", "Scene.solids that yield", "Scene.rolling"),
     "faces of such bodies are not computed, leave one of them out, or end the contact by a FiniteLength"),
    ("Scene.solids with free_faces",
     ("Scene.friction with stick", "Scene.friction of unequal bodies", "friction and Scene.outputs"),
     "how faces change the response to tangential traction is not computed, leave free_faces out, or end the contact by "
     "a FiniteLength"),
    # adhesion
    ("Scene.adhesion", ("Scene.wear",),
     "Archard's law does not say how much the attraction wears, leave one of them out"),
    ("Scene.adhesion", ("Scene.lubrication",),
     "a film keeps the surfaces out of each other's reach, leave one of them out"),
    ("Scene.adhesion", ("Rolling.passes", "rolling of Scene.solids that creep"),
     "such bodies part behind with more work than they join with ahead, which is not computed, give elastic bodies "
     "without passes, or leave one of them out"),
    ("Scene.adhesion", ("Fretting.times",), "the contact jumps, give forces without times"),
    ("Adhesion.range is None", ("Scene.friction", "Scene.solids that yield"),
     "in the limit of short ranges the attraction grows without limit as the cells get smaller, and with it friction "
     "and plastic strain, give Adhesion.range"),
    # wear
    ("Scene.wear", ("Scene.lubrication without a boundary film",),
     "the film keeps the bodies apart, so that nothing wears, give Lubrication.boundary, or leave wear out"),
    ("Wear.speed", ("Scene.lubrication", "TractiveRolling", "Fretting"),
     "the sliding follows from these, give a speed of 0 m/s"),
    ("Scene.wear of a body that turns or in a film",
     ("Scene.load that changes", "Fretting.times", "Scene.solids at rest that creep or yield"),
     "such wear is followed from one steady contact to the next, give a LineLoad, no times, and bodies that are elastic "
     "or roll"),
    # films
    ("Scene.lubrication", ("Scene.rolling",), "Lubrication.mean_speed moves the surfaces already, leave rolling out"),
    ("Scene.lubrication", ("Scene.friction",),
     "Lubricant.shear and the boundary film give the friction, leave Scene.friction out"),
    ("a change in time under a film", ("Scene.solids that creep", "Lubrication.boundary", "Lubrication.thermal"),
     "these are computed under a steady film only, leave one of them out"),
)  # fmt: skip
