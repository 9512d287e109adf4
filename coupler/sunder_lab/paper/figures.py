"""The figures of the paper: what each shows and says, how it is made here, what differs and why."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

from . import drawings, views
from .drawings import Drawn
from .runs import Runs


@dataclass(frozen=True)
class Figure:
    """A figure. `says`: what the paper shows and says. `differs`: what is not as there, and why. Without `draw` the
    figure is a drawing of the method, and there is nothing to run."""
    number: int
    title: str
    says: str
    cases: tuple[str, ...] = ()
    differs: tuple[str, ...] = ()
    draw: Callable[[Runs], Drawn] | None = None


DRAWING = "A drawing of the method; there is nothing to run."
CHOSEN = "The paper gives no thickness, fracture energy or loading. They are chosen, and stated in the scene."

FIGURES = {figure.number: figure for figure in (
    Figure(1, "A car, an impactor and a tree",
           "A car of 12 patches of several materials. A heavy impactor breaks the bumper into three pieces, the bonnet is bent "
           "for good and breaks, then a tree falls and perforates the windscreen, which cracks as laminated glass does.",
           ("fig01",),
           ("Bumper and glass break. The bonnet bends for good and tears at its edges, beside the block and the wings. In the "
            "paper it breaks.",
            "The car is made by a script; the paper's model is not public.",
            "It runs at the paper's values for density, stiffness and strength. Thickness, fracture energy, yield stress, "
            "impactor and tree are chosen. The tree stands and falls freely, so more than the paper's 0.06 s are simulated."),
           views.figure_1),
    Figure(2, "Parameter domain, reference and deformed surface", DRAWING),
    Figure(3, "Overview of the system", DRAWING),
    Figure(4, "Over-stretching",
           "(a) With the original phase field, material near the crack is severely stretched when the shell is cut. (b) With "
           "healing and explicit cracks it is not.",
           ("fig04_maximum", "fig04_cut", "fig04_healing"),
           (CHOSEN, "The picture in the middle has maximum damage as (a), and cuts as (b): it does not stay stretched either. "
            "So it is the cut that lets the material come back, not healing: what is fully damaged is cut in the substep in "
            "which that completes, and nothing pulls on it then."), drawings.figure_4),
    Figure(5, "c and c_his",
           "The evolution of c (below) and c_his (above). The region of c_his grows with the crack; c vanishes where the "
           "pieces have parted.", ("fig04_healing",),
           ("The paper does not say which scene it shows; here it is that of Fig. 4 (b).",
            "c stays at single points of the border. They are rubble: cracks have left them no support, nothing moves them, and "
            "they bear nothing."), drawings.figure_5),
    Figure(6, "Extraction of a crack by Fan et al. 2022", DRAWING),
    Figure(7, "Extension, connection and branching of a crack", DRAWING),
    Figure(8, "Consistent cracks",
           "(a) A damaged region in three stages, cyan, green and pink. (b) Crack paths of Fan et al. 2022, taken anew at each "
           "stage, do not agree. (c) Those of the paper do: later cracks extend earlier ones.", ("fig14_even",),
           ("The paper does not say which scene it shows; here it is that of Fig. 14 (a).",
            "(b) is made by thinning the damaged pixels. Fan et al. take the Voronoi diagram of the region's border: another "
            "way to the same middle line.",), drawings.figure_8),
    Figure(9, "Area of a torn sheet by stress model",
           "Of a torn sheet of 1 m2, 0.668 m2 are left with the model of Jiang et al. 2017 (red); with that of Guo et al. "
           "2018 (purple) material separates near the crack; with the paper's (green) 0.994 m2 are left.",
           ("fig09_ours", "fig09_plane_stress", "fig09_jgt17", "fig09_ghf18"),
           (CHOSEN, "The area comes back with every model here, those of Jiang and Guo included. What is missing of 1 m2 are points "
            "at the crack that it has left without support. shell/mechanics/README.md derives why: none of the four energies "
            "is stationary but at rest, and strain is computed from positions. Only a scheme that carries the deformation "
            "gradient forward can end with less area. The paper gives no parameters with which that could be repeated."), drawings.figure_9),
    Figure(10, "Support of a quadrature point near a crack", DRAWING),
    Figure(11, "Mode I, mode II, and a plate under pressure",
           "(a) Under mode I the crack goes straight on. (b) Under mode II it turns off. A simply supported plate under "
           "uniform pressure breaks as in Kiendl et al. 2016, Fig. 12.",
           ("fig11_mode_one", "fig11_mode_two", "fig11_plate"),
           ("(a) and (b) run in the paper's mode, DAMAGE. (c) runs in mode TIPS: with the strength and fracture energy of "
            "glass, the paper's law needs spacings below 0.2 mm. It is a pane of glass that breaks at once, in motion; Kiendl "
            "et al. load a plate slowly. So its first cracks are to be compared: from near the middle towards the corners. Table 2 "
            "has no row for this figure.",
            "Mode DAMAGE was tried for (c), without healing, with 150 times the fracture energy of glass and four times the "
            "pressure. It draws diagonals from the corners that a ring around the middle joins. But its cracks add energy, more "
            "than 1 % of what they take, on both grids that were tried and under a slower load. So the figure stays with TIPS.",
            "The paper restrains the crack of (b) by a boundary condition at the lower edge. Here that edge is held."),
           drawings.figure_11),
    Figure(12, "A bullet through thin metal",
           "A fast bullet pierces a thin sheet of metal, leaves a clean cut and a permanent deformation; debris flies on.",
           ("fig12",),
           ("The paper gives no yield stress and no hardening; they are chosen. The sheet yields less than in the scene, which "
            "runs in mode TIPS: a sheet that weakens is punched before it is drawn out.",
            "Damage does not heal here: a torn flap that folds back would gain energy as it heals."), views.figure_12),
    Figure(13, "A spiral cut", "A sheet is cut beforehand along an Archimedean spiral, exactly.", ("fig13",),
           ("How the sheet is held and pulled is chosen: the rim is held and the middle is pulled up.",), views.figure_13),
    Figure(14, "Two bunnies on a cloth",
           "Two rigid bunnies fall on a cloth that is held along its four edges. (a) Even cloth: branching and merging cracks. "
           "(b) With a weakened region the cracks start there, and go on beyond it.", ("fig14_even", "fig14_weakened"),
           ("The bunnies are nine ellipsoids each, joined. One surface of that shape has more convex parts than an engine takes.",
            "The shape of the weakened region is chosen. The cloth has no fibres (type III): it does not touch itself here, and they "
            "would bear nothing.",
            "In places cracks leave rubble, where the paper shows clean lines: the cloth is fully damaged over several elements "
            "at once, and all of them are cut."), views.figure_14),
    Figure(15, "A garment, torn",
           "A garment is fixed at its shoulder straps and pulled at its bottom. Branching cracks pass over the borders of "
           "patches and leave three fragments.", ("fig15",),
           ("The garment is made by a script. Nothing breaks where straps are stitched on. It tears just below: the straps leave "
            "with a part of the panels that they hold, and the body stays. The paper's tears run through the garment and branch.",
            "At the tears strips of an element's width stand out. They are stretched and never part.",
            "It ends soon after the straps have torn off: small pieces at the tears become unstable later. The paper goes on to "
            "1.2 s. The cloth has no fibres (type III). Its panels touch one another and themselves by contact between shells, "
            "which is inelastic."), views.figure_15),
    Figure(16, "A mannequin that is inflated",
           "The body of a mannequin in a blue dress is inflated at rest. Cracks pass over the borders of patches and tear the "
           "dress into fragments, in several tears.", ("fig16",),
           ("Figure and dress are made by a script; the paper's are not public. The dress has two straps and stands 3.5 mm off "
            "the body at first. How far and how fast the body is inflated is chosen.",
            "It tears off its straps in front and down both sides. In the small size front and back still hang together by "
            "shreds; the paper's are apart. Strips at a tear are stretched to many times their length and never part, as in "
            "Fig. 15. Some of their points lie in the body: contact is felt at Gauss points, which a torn strip no longer has. "
            "Now and then one of them folds over in one step and makes energy; then the run warns. The cloth has no fibres "
            "(type III). Its panels touch one another and themselves by contact between shells, which is inelastic."),
           views.figure_16),
    Figure(17, "A marble on glass",
           "A ball hits a thin glass. Cracks start at the contact and form several circles outwards, with angular pieces. A "
           "rigid-body solver moves the fragments.", ("fig17",),
           ("The pane has a side of 3.95 m: so wide is one with the spacing and the points of Table 2. Its thickness, the marble and the "
            "fracture energy are chosen; the strength scatters, as that of glass does.",
            "It runs in mode TIPS, in which cracks are driven by the fracture energy. The paper's law would "
            "need at least 131 J/m2 on its grid, sixteen times that of glass."), views.figure_17),
    Figure(18, "Shares of time",
           "Of the time of the garment's simulation, elasto-dynamics takes some 85 %, the four parts of fracture 15 %.",
           ("fig15",),
           ("Contact between shells is a stage of its own here; in the paper the grid does it within elasto-dynamics.",),
           drawings.figure_18),
)}

NUMBERS = tuple(FIGURES)
