#pragma once
// The constants of fracture: every number that decides where a crack starts, how far and where it runs, what it joins,
// and what becomes of a piece. Each has its symbol (where it has one), unit and meaning in the first lines, and in the
// last one its class and source:
//   derived        follows from an equation
//   published      taken from a publication
//   calibrated on CASE   fitted or chosen by eye; `validate cracks --case sensitivity` changes it by 20 % on that case
//   numerical      chosen for the grid, the solver or its cost; no physical source
// Unit [h]: the spacing, the mean length of an element. [tau]: the thickness. [-]: a ratio.
// Constants of round-off, of cost, of the material law and of sampled curves stay beside what uses them.
#include <cstddef>
#include <numbers>

namespace sunder::shell {

// ---- Tips: stress ahead and direction

/// R [h]: radius of the mean stress ahead of an end and around a flaw; the scene may set `tip_radius_m`.
/// numerical: the reference means are taken over the same R, so a singular field does not depend on it
/// (`energy_release`)
constexpr double kTipRadius = 2.0;
/// [-]: a in the weight exp(-a r^2 / R^2) of a Gauss point in that mean.
/// numerical: kRadialMean belongs to it
constexpr double kRadialFall = 2.0;
/// [-]: mean of sqrt(R / r) with that weight over 0 < r < R, from the integral of s^(1/2) exp(-2 s^2) over that of
/// s exp(-2 s^2), 0 < s < 1.
/// derived: quadrature
constexpr double kRadialMean = 1.5420;
/// [rad]: Gauss points further round than this from the direction of a tip lie beside the flanks of its crack.
/// numerical: part of the reference means as well
constexpr double kFlankAngle = 120.0 * std::numbers::pi / 180.0;
/// theta_w [rad]: standard deviation of the Gaussian weight about a direction.
/// numerical: part of the reference means as well
constexpr double kWedge = 40.0 * (std::numbers::pi / 180.0);
/// [rad]: between two directions that are tried; a parabola finds the top between them.
/// numerical: resolution
constexpr double kTurnStep = 5.0 * (std::numbers::pi / 180.0);
/// [-]: points of the quadrature of the reference means over the angle.
/// numerical: resolution
constexpr int kWedgePoints = 480;
/// [h]: visibility of a tip is tested from a point this far ahead of it; its own edge would hide points.
/// numerical: small against the distance of Gauss points
constexpr double kEyeAhead = 0.1;
/// [of the distance]: a crack edge is visible from a point if its foot is, less this.
/// numerical: small, above round-off
constexpr double kShortOfEdge = 0.02;
/// [rad]: turn of the opening direction of a bent crack towards the diagonal of the lattice, times sin(4 angle) and the
/// share of bending; it is taken off.
/// calibrated on energy_release: measured on square elements of degree 2 (rows `..._lattice_turns`)
constexpr double kToDiagonal = 3.7 * std::numbers::pi / 180.0;
/// [rad]: largest change of direction of a tip per edge.
/// calibrated on struck_pane: by eye, no source; a scene of the case sensitivity
constexpr double kMostTurn = 10.0 * (std::numbers::pi / 180.0);
/// [rad]: the same for the first edge of a crack that starts at the end of a cut.
/// published: above 70.5 degrees, the kink in pure mode II (Erdogan and Sih 1963); the margin is chosen
constexpr double kFirstTurn = 80.0 * std::numbers::pi / 180.0;
/// [h, h, of the outer]: radius of the ring of J; the least, below which mean stress drives; where the advance falls.
/// numerical: the wider the ring, the less J depends on the place of a tip in the grid (`energy_release`)
constexpr double kReleaseOuter = 4.0, kReleaseLeast = 2.5, kReleaseInner = 0.25;
/// [rad, h]: an edge within this angle and margin behind a tip is its own course, over which J changes little.
/// numerical: a sharp kink behind a tip keeps its ring; the arms of a division do not
constexpr double kWake = 60.0 * std::numbers::pi / 180.0, kWakeMargin = 0.3;
/// [h]: credited to a young tip beyond its length, half of its next edge, as its resistance passes to the energy.
/// numerical: middle of the edge
constexpr double kCreditedLength = 0.5;

// ---- Tips: speed, edges, division

/// [h]: length of a new edge, of tips and of damage. In mode TIPS, how far a crack runs in one go, unless that would
/// add energy (kEdgesTried). In mode DAMAGE one look cuts a whole line of complete damage, or on by kDamagedReach.
/// numerical: below one spacing, so that a crack follows the field of each element
constexpr double kEdgeLength = 0.75;
/// [edges]: way of a tip at full speed between two looks at the cracks.
/// numerical: resolution
constexpr double kLookShare = 0.5;
/// [edges]: lengths tried in turn, where a shorter one would add energy.
/// numerical: what changes around a tip costs the same for any length
constexpr double kEdgesTried[] = {1.0, 1.5, 2.0, 3.0, 4.0};
/// [attempts]: a refused tip tries the longer ones at every such attempt.
/// numerical: cost; most tips that are refused once are refused again and again
constexpr int kLongerTried = 5;
/// [edges]: pending length that a refused tip keeps.
/// numerical: cost of trying again
constexpr double kRefusedPending = 0.25;
/// g_b [G_f]: energy release above which a tip divides, of a material that gives no `branch_drive`.
/// derived: two arms need twice the fracture energy, a necessary condition
constexpr double kBranchDrive = 2.0;
/// [stress times the root of its length]: stress intensity of a crack as it divides.
/// published: half-penny mirrors of glass, from which its `branch_drive` is; through cracks of `mirror` divide near it
constexpr double kMirrorIntensity = 1.26;
/// [h]: a shorter mirror (mirror_length) is not resolved: the grid decides where cracks divide.
/// numerical: in `mirror` the constant holds within its bound from there on
constexpr double kResolvedMirror = 5.0;
/// [h]: of a mirror below it no finer grid is advised.
/// numerical: five times as many elements along each side is the most that is affordable
constexpr double kRefinableMirror = 1.0;
/// [rad]: angle of each arm to the direction of the tip that divides.
/// derived: that of short arms without shear at their tips (a test finds 26.9 degrees)
constexpr double kBranchAngle = 27.0 * (std::numbers::pi / 180.0);
/// [a_c]: length of a whole critical crack; no division and no full resistance over a seam before it is reached.
/// derived: a_c is half of it (critical_length)
constexpr double kWholeCrack = 2.0;
/// [h]: no division with another crack within kBranchRoom of the point this far ahead.
/// numerical: room for two arms
constexpr double kBranchLook = 2.0, kBranchRoom = 1.5;
/// [h]: edges of the tip's own crack that end so near behind it do not take that room.
/// numerical: the last two edges
constexpr double kBranchOwn = 2.0;
/// [h]: least distance that the grid resolves between cracks: no division with another tip so near, no new crack so
/// near ahead of a tip or beside a nearly parallel crack.
/// numerical: a strip of two elements holds two rows of control points, the fewest that give a slope; and half of one
constexpr double kClearance = 2.5;

// ---- Tips: joining and ending

/// [h]: reach ahead of an edge within which a tip ends on another crack or on the border.
/// numerical: no strip narrower than an element is left
constexpr double kJoinReach = 1.0;
/// [of that reach]: a tip snaps to a crack so near to its new end.
/// numerical: as kJoinReach
constexpr double kSnapShare = 0.7;
/// [h]: most that the snap may lie behind the new end.
/// numerical: as kJoinReach
constexpr double kSnapBehind = 0.1;
/// [h]: an end goes so far past the crack that it joins, so that nothing sees between; for tips, new cracks, damage and
/// cuts.
/// numerical: visibility; above kLoopMet
constexpr double kJoinPast = 2e-3;
/// [h]: an end of a crack that runs out goes so far over the border.
/// numerical: visibility
constexpr double kRunOut = 0.1;
/// [-]: cosine between a tip and a closed crack of the other face, above which the tip joins it instead of crossing.
/// numerical: half-way between along it and across it, 45.6 degrees
constexpr double kCrossingCosine = 0.7;
/// [h]: two tips so near have met.
/// numerical: above kJoinPast
constexpr double kTipsMet = 0.05;
/// [h]: edges of its own crack, or of its sibling's, so near a tip cannot be joined.
/// numerical: else a tip would join what it has just cut
constexpr double kOwnEdges = 2.0;
/// [h]: an end of a cut with another crack so near is not open.
/// numerical: far above kJoinPast, below an edge
constexpr double kEndTaken = 0.1;

// ---- New cracks

/// sigma_low / sigma_high [-]: principal stresses nearer than this leave the direction of a new crack to chance.
/// numerical: of flaws in all directions with a Weibull modulus of 7, those across the lower one open 0.8^7 as often, a
/// fifth
constexpr double kAlike = 0.8;
/// [tau]: no new crack so near beside a nearly parallel one.
/// numerical: stress beside a crack of a face recovers over the thickness; twice that, since two cracks share it
constexpr double kParallelThickness = 2.0;
/// [-]: cosine above which directions count as parallel: of cracks that shield one another, of a crack and a clamp.
/// numerical: 31.8 degrees
constexpr double kParallelCosine = 0.85;
/// [h]: points so little behind a tip count as beside it.
/// numerical: half an element
constexpr double kBesideTip = 0.5;
/// [h]: a crack that starts so near another starts on it.
/// numerical: no strip narrower than an element is left
constexpr double kStartsOnCrack = 1.5;
/// [h]: length of the first edge of a new crack, and of one that has come over a seam.
/// numerical: an element
constexpr double kFirstEdge = 1.0;
/// [1/energy]: half of the line is the shortest that opens, which needs an energy of at least one over it.
/// derived: opens_along with its shortest line
constexpr double kShortestOpens = 2.0;
/// [-]: sectors of the energy-release zone.
/// numerical: resolution
constexpr int kZoneSectors = 16;
/// [elements each way]: a larger energy-release zone is sampled.
/// numerical: cost
constexpr int kZoneSamples = 16;
/// [h]: bound of lengths that may be infinite.
/// numerical: no shell has so many elements
constexpr double kFarthest = 1e6;
/// [m]: cell of the scatter of the strength; the scene may set `flaw_spacing_m`.
/// calibrated on struck_pane: by eye, no source; a scene of the case sensitivity
constexpr double kFlawSpacing = 4e-3;

// ---- Along a clamped border

/// [h]: a crack along a clamped border lies so far inside, where the border's control points are not visible.
/// numerical: geometry; below kBorderTolerance
constexpr double kOnBorder = 5e-4;
/// [-]: sine of the angle to a clamped border beyond which a tip leaves it.
/// numerical: 17.5 degrees, more than kMostTurn
constexpr double kLeavesClamp = 0.3;
/// [edges]: a tip so near a clamped border that it follows is on it with its next edge.
/// numerical: one that comes on at a small angle weaves in and out
constexpr double kOntoClamp = 0.5;

// ---- Faces of fresh cracks

/// [tau]: faces further apart at both points bear no more; the scene may set `interlock_opening_m`.
/// numerical: open faces bear nothing; a piece waits so long until it may leave
constexpr double kInterlockOpening = 0.05;
/// mu [-]: coefficient of friction between crack faces, of a material that gives no `crack_friction`.
/// published: sliding, dry glass on glass 0.40 (Marks' Standard Handbook for Mechanical Engineers, table of
/// coefficients of friction); taken for all
constexpr double kCrackFriction = 0.4;
/// [strength]: pressure at which faces crush, of a material that gives no `crushing_strength`.
/// published: compressive over tensile strength of glass and ceramics, about; the number is chosen
constexpr double kCrushingOverStrength = 10.0;
/// [-]: cosine between the normals of the two faces below which they release.
/// numerical: the frame of the gap has no meaning beyond it
constexpr double kFacesCosine = 0.7;
/// [of the area at rest]: faces release where their tangents' parallelogram is smaller, or larger.
/// numerical: crushed surroundings, or stretched ones
constexpr double kFacesLeastArea = 0.5, kFacesMostArea = 2.0;
/// [of the area at rest]: a side that is smaller has no normal, and bears nothing until it releases.
/// numerical: above round-off
constexpr double kNoFrame = 1e-3;
/// [h strength / E]: least depth over which faces grow stiff.
/// numerical: a kink in the stiffness makes energy
constexpr double kClosingDepth = 0.05;
/// [h]: most of that least depth.
/// numerical: as kClosingDepth
constexpr double kMostClosing = 1e-3;
/// [travels in a substep]: depth over which faces that close grow stiff.
/// numerical: energy error of a kink
constexpr double kClosingTravels = 12.0;
/// [1/(rho h A)]: mobility of a gap from which on its stiffness is reduced.
/// numerical: stable step
constexpr double kMostMobility = 4.0;
/// [h]: points of a face lie so far beside the edge.
/// numerical: visibility
constexpr double kFaceBeside = 1e-3;
/// sum N^2 [-]: most of the functions of a face, about 1 at the edge of a support; of a plane also of its slopes times
/// the spacing.
/// numerical: stable step
constexpr double kFaceAmplification = 3.0;
/// cond(A) [-]: of planes through the few points that a face sees.
/// numerical: kFaceAmplification decides
constexpr double kFaceCondition = 1e4;

// ---- Insertion

/// [of its energy]: a Gauss point that would store more after a crack changed its functions is rubble, without damage.
/// numerical: between torn faces one-sided functions see distances that are no strain
constexpr double kMostGain = 4.0;
/// [E]: energy per volume that such a point may have besides, that of a strain of 1.4 %.
/// numerical: as kMostGain
constexpr double kFreeEnergy = 1e-4;
/// [h]: crack edges block visibility so far past their ends.
/// numerical: round-off and corners
constexpr double kLengthening = 1e-2;
/// [kLengthening]: shorter edges have no length.
/// numerical: round-off
constexpr double kNoLength = 1e-3;

// ---- Cracks from damage

/// l [h]: width over which damage localises; the scene may set `damage_width_m`.
/// published: paper section 5.1, the spacing of its Gauss points
constexpr double kDamageWidth = std::numbers::sqrt3;
/// [strength]: from this face stress on a Gauss point is listed for damage.
/// numerical: a layer may bear more than the face tells
constexpr double kWatched = 0.8;
/// [surface compression]: tension in the middle of a tempered sheet.
/// derived: parabolic profile from -s to s/2 with no resultant
constexpr double kTemperedMiddle = 0.5;
/// [h]: damage so near a crack is that crack's.
/// calibrated on torn_sheet: by eye
constexpr double kSpentBeside = 1.25;
/// [h]: a shorter middle line waits until it has grown.
/// calibrated on torn_sheet: by eye
constexpr double kShortestLine = 1.5;
/// [h]: a shorter side line is noise of the boundary.
/// calibrated on torn_sheet: by eye
constexpr double kSpur = 1.5;
/// [share]: a middle line is cut where so many of its points are damaged at present; else waves have passed.
/// calibrated on torn_sheet: by eye
constexpr double kUnhealed = 0.5;
/// [h]: reach of an end over damaged material; complete damage along a seam from which on it opens (seam_damage.h),
/// longer than a band across is wide.
/// calibrated on torn_sheet: by eye
constexpr double kDamagedReach = 5.0;
/// [share]: of a way's cells that make it damaged.
/// calibrated on torn_sheet: by eye
constexpr double kThroughDamage = 0.8;
/// [share]: of the cells around, from which on damage is broad: no middle line tells where the crack goes.
/// calibrated on torn_sheet: by eye
constexpr double kBroadDamage = 0.7;
/// [rad]: largest turn of an end per edge in broad damage.
/// calibrated on torn_sheet: by eye
constexpr double kDamageTurn = 20.0 * std::numbers::pi / 180.0;
/// [stress of complete damage]: points stretched further are rubble.
/// calibrated on torn_sheet: by eye
constexpr double kTornStress = 16.0;
/// [of the area at rest]: a spent point is folded where a layer keeps less, or less of a length than its middle does,
/// and crushed where its middle keeps less.
/// numerical: a sheet folded about a radius of its thickness leaves its pressed face half of its area. Such a fold is
/// no longer thin. Its stiffness would set the step of the whole shell.
constexpr double kFoldedArea = 0.6;
/// [h]: reach of an end over sound material.
/// numerical: as kStartsOnCrack
constexpr double kSoundReach = 1.5;
/// [h]: a way that passes another open end so near is refused.
/// numerical: it would run along that end's crack
constexpr double kPassesEnd = 0.25;
/// [h]: an end so little past a crack that its edge has met has joined it.
/// numerical: above kJoinPast
constexpr double kEndJoined = 0.01;
/// [-]: cosine below which what an end may join is not ahead.
/// numerical: 72.5 degrees
constexpr double kAheadCosine = 0.3;
/// [h]: a way is looked along to so little before its end.
/// numerical: above round-off
constexpr double kShortOfWay = 1e-3;
/// [h]: steps in which an end looks for the border.
/// numerical: resolution
constexpr double kBorderSteps = 0.25;
/// [of the distance]: visibility of an end of damage is tested from so far on the way.
/// numerical: its own edge would hide points
constexpr double kEyeShare = 0.01;
/// [h]: middle lines are moved off the lattice of control points, along (kNudgeU, kNudgeV).
/// numerical: ties in visibility
constexpr double kOffLattice = 0.013;
/// [-]: direction in which lines are moved off lattice lines.
/// numerical: along neither axis nor diagonal
constexpr double kNudgeU = 1.0, kNudgeV = 1.3;
/// [1/h]: samples along a way of which the damaged share is taken.
/// numerical: resolution
constexpr double kWaySamples = 4.0;
/// [cells each way]: window in which damage may be broad.
/// numerical: resolution
constexpr int kBroadWindow = 3;
/// [cells each way]: a normal is that of the blurred region, not of its steps.
/// numerical: resolution
constexpr int kNormalBlur = 2;
/// [-]: passes of (1, 2, 1)/4 over a middle line, which smooth the steps of the cells.
/// numerical: cells are small against an edge
constexpr int kSmoothings = 4;
/// [distance of the seeds]: Voronoi vertices nearer than this are one.
/// numerical: round-off
constexpr double kSamePlace = 1e-6;
/// [-]: cosine between the outward normals of two seeds below which they face each other.
/// numerical: paper section 5.2 names the rule, not the number
constexpr double kFacingSeeds = -0.3;

// ---- Prescribed cuts

/// [h]: a cut that ends so near the border runs out.
/// numerical: as kEndTaken
constexpr double kCutAtBorder = 0.1;
/// [h]: a cut that runs out goes so far over the border.
/// numerical: visibility of all control points beside it
constexpr double kCutRunOut = 1.01;
/// [h]: a crack that ends on a trim loop goes on outside so far, in the region that is cut away.
/// numerical: visibility; further than control points that stay outside of a loop
constexpr double kTrimRunOut = 1.5;
/// [-]: cosine with the outward normal of a trim loop above which a crack goes on outside straight on; else along the
/// normal.
/// numerical: a flat way would stay near the loop
constexpr double kLeavesLoop = 0.3;
/// [h]: a cut so near a crack, or a vertex of one, meets it.
/// numerical: far above kJoinPast
constexpr double kCutOnCrack = 0.02;
/// [h]: cuts of cubic patches are moved off the knots, where control points lie, along (kNudgeU, kNudgeV).
/// numerical: ties in visibility
constexpr double kOffKnots = 1e-6;
/// [h]: smaller circles, and turns of a spiral nearer than this, are refused.
/// numerical: no Gauss point lies between
constexpr double kSmallestRound = 0.5;

// ---- Shape functions beside a crack (README of this folder, "Choice of the support")

/// d [h]: first support that is tried.
/// numerical: stable step (`cuts`, `joints`, `spiral`); 1.5 is too stiff at borders
constexpr double kSmallestSupport = 2.0;
/// d [h]: last of the well conditioned supports.
/// numerical: stable step, same rows
constexpr double kLargeSupport = 4.5;
/// [h]: step of supports; twice that for the linear basis.
/// numerical: stable step, same rows
constexpr double kSupportStep = 0.25;
/// d [h]: support of points that see one side only, and the reach of visibility. A cut just short of a row of control
/// points leaves the fifth row 4.7 spacings off; with weight on four alone the rows beside the cut are too stiff.
/// numerical: stable step, same rows
constexpr double kLargestSupport = 5.5;
/// cond(A) [-]: most of the quadratic basis.
/// numerical: stable step, same rows
constexpr double kGoodCondition = 200.0;
/// cond(A) [-]: most of the quadratic basis with kLargestSupport, then kLargeSupport.
/// numerical: stable step, same rows; 3000 lets narrow strips move too stiffly
constexpr double kLastCondition = 2500.0;
/// cond(A) [-]: most of the linear basis.
/// numerical: stable step, same rows; 37 lets narrow strips move too stiffly
constexpr double kLinearCondition = 34.0;
/// [control points]: fewest that the quadratic basis takes.
/// published: paper section 7.2
constexpr int kLeastQuadratic = 9;
/// [control points]: fewest that the linear basis takes.
/// numerical: one more than it needs
constexpr int kLeastLinear = 4;
/// [control points]: fewest that a plane through a face takes.
/// derived: a plane has three
constexpr int kLeastPlane = 3;

// ---- Pieces

/// [h^2]: a smaller piece leaves at once.
/// numerical: too small to bend
constexpr double kSmallPiece = 30.0;
/// [h/c_P]: a larger piece stays so long after it came loose, or after its last crack.
/// numerical: waves may still crack it
constexpr double kSettleWaves = 40.0;
/// [h^2]: smaller slivers join their largest neighbour.
/// numerical: left where joins cross what they join
constexpr double kSliver = 0.02;
/// [h]: what is nearer to the border lies on it, and parts no strip of it.
/// numerical: below kJoinPast
constexpr double kBorderTolerance = 1e-3;
/// [h]: knots nearer to a crack are left out of the triangles.
/// numerical: slivers
constexpr double kKnotClearance = 0.15;
/// [h]: crack edges so near have met.
/// numerical: above round-off, below kJoinPast
constexpr double kLoopMet = 1e-3;
/// [h^2]: most that a convex part may add to the outline of a piece.
/// numerical: collision shape
constexpr double kPartTolerance = 0.1;
/// [of the area]: smaller convex parts are left out.
/// numerical: round-off
constexpr double kLeastPart = 1e-6;
/// [of its first mass]: a control point keeps at least this share, however many pieces leave beside it.
/// numerical: the stable step falls with the root of the mass
constexpr double kMassKept = 0.5;
/// [of its first mass]: the same where that is not enough.
/// numerical: the last pieces
constexpr double kLastMassKept = 0.02;
/// [of its first mass]: a control point keeps at least this share when a seam releases another.
/// numerical: as kMassKept
constexpr double kSeamMassKept = 0.25;
/// [control points]: most of those beside a piece that balance its mass, and how many are asked for at first.
/// numerical: cost
constexpr std::size_t kMostBalancing = 192;
/// [control points]: fewest that balance a mass, and those that take the excess momentum of a piece.
/// numerical: three times the four sums that they balance
constexpr std::size_t kFewestBalancing = 12;
/// [h]: they are looked for within this first.
/// numerical: cost
constexpr double kBalancingReach = 8.0;
/// [-]: misfit of the balanced sums at which the masses do.
/// numerical: control points of a bent piece do not fit exactly
constexpr double kBalancingMisfit = 1e-3;
/// [-]: least over largest moment of inertia below which control points lie in a line and cannot take a spin.
/// numerical: above round-off
constexpr double kInALine = 1e-3;
/// [of its length at rest]: edges of triangles that are longer are no surface.
/// numerical: control points of rubble fly off
constexpr double kNoSurface = 4.0;
/// [tau]: a piece further off a plane is divided into convex parts that are not.
/// numerical: shape of a body
constexpr double kBentPiece = 0.5;
/// [s]: cracking has ended when so long nothing cracked; the scene may set `quiet_time_s`.
/// numerical: a wave of 5000 m/s, as in glass, crosses 2.5 m of shell
constexpr double kQuietTime = 5e-4;
/// [of the length]: growth of cracks in that time that still counts as quiet; the scene may set `quiet_growth`.
/// numerical: the last per cent of the length, below what seeds change of it
constexpr double kQuietGrowth = 0.01;

// ---- Seams

/// [rows]: control points that a seam joins on each side.
/// derived: a tangent plane in common needs two
constexpr int kSeamRows = 2;
/// [rad]: creases from here on keep the distance of the rows beside the seam, flatter ones its height over the line
/// between them.
/// numerical: the height of a sharp crease hardly changes with its angle
constexpr double kSharpCrease = std::numbers::pi / 3.0;
/// [distance of the rows]: a seam no further off that line is smooth.
/// numerical: round-off of geometry
constexpr double kSmoothSeam = 1e-3;
/// [h]: a crack beside a seam parts it so far beyond its ends.
/// numerical: visibility is blocked just beyond an end
constexpr double kSeamPad = 1.0;
/// [-]: least sine of the angle to a trimmed seam at which a crack goes on beyond it.
/// numerical: a flatter way would stay within an element of the seam
constexpr double kLeastCrossing = 0.25;
/// [h]: a crack that has ended no further from a trimmed seam has ended on it.
/// numerical: a tip stops at a loop to round-off; the rest is room for seams whose sides lie a little apart
constexpr double kOnTrim = 0.1;
/// [h]: a crack does not go on over a trimmed seam where another has come within this of its place.
/// numerical: within an edge, so that the same crack does not cross twice
constexpr double kCrossedBefore = 0.5;
/// [h]: the first edge beyond a trimmed seam, halved from kFirstEdge until it ends inside, ends below this.
/// numerical: where a shell is narrow there is room for no longer one
constexpr double kShortestFirst = 0.25;
/// [h]: an edge of a trim loop no further from the places of a tied seam is tied: to cracks it is no free border.
/// numerical: loops and places are samples of one curve
constexpr double kOnTied = 0.1;

// ---- Ties along trims, beside cracks

/// [of a whole hat function]: a hat of which cracks leave less goes to the one beside it.
/// numerical: a small hat weighs few places
constexpr double kLeastHat = 0.4;
/// [of an element]: a stretch between two cracks that is shorter ties nothing.
/// numerical: cracks of both shells that are one may meet the seam a little apart, and what lies between them would
/// join their sides
constexpr double kLeastStretch = 0.3;
/// [h]: control points that a crack hides from a place of a tie are those hidden from a point so far inside the border.
/// numerical: a place on the border lies on the edges of its loop; small against the distance of Gauss points
constexpr double kEyeInside = 0.02;
/// [of the largest weight of a row]: change of weights that may close the gap of a row which cracks have changed. At
/// rest it is kMostChange.
/// numerical: functions beside cracks find a place less exactly than those of the patch
constexpr double kMostRenewed = 0.5;

// ---- Trimmed patches, beside cracks

/// [of its mass in the whole patch]: functions beside cracks leave out control points of which loops leave less.
/// numerical: functions of less mass move too stiffly
constexpr double kLightMass = 0.2;
/// [h]: visibility of a control point outside a trim loop is that of the nearest point this far inside.
/// numerical: far above round-off, far below an edge
constexpr double kHomeInside = 1e-3;

// ---- Stable step

/// [free stable step]: a shell that can crack starts with this; a crack born within a window must not find the step too
/// large.
/// calibrated on struck_pane: measured steps of shells full of cracks, of the intact one's
constexpr double kCrackedStep = 0.8;
/// [windows]: between two measurements of the stable step near new cracks.
/// numerical: later, single cracks made energy
constexpr int kStepWindows = 4;
/// [windows]: the same where there is damage.
/// numerical: as kStepWindows
constexpr int kDamagedStepWindows = 8;

}  // namespace sunder::shell
