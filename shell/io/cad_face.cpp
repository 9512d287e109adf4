// With cad_file, the only files that use OpenCASCADE.
#ifdef SUNDER_CAD

#include "shell/io/cad_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include <BRepGProp.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <GeomConvert.hxx>
#include <GeomConvert_ApproxSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Precision.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Wire.hxx>

#include "shell/geometry/edges.h"
#include "shell/io/cad_region.h"

namespace sunder::shell {
namespace {

using Spline = opencascade::handle<Geom_BSplineSurface>;
using Surface = opencascade::handle<Geom_Surface>;

// Shares of the face's size. Files have tolerances of about a micrometre; no feature of a shell is that fine.
constexpr double kTrimTolerance = 1e-5;    // a border this near a side of the parameter rectangle runs on it
constexpr double kApproximated = 1e-5;     // a surface of a higher degree may be off by this
constexpr double kSmoothTolerance = 1e-9;  // the surface may move by this where a needless knot is removed
constexpr double kSnapTolerance = 1e-7;    // share of the parameter range: a border this near a knot is moved to it
constexpr double kCornerTolerances = 2.0;  // of a corner of the file: as far may the ends of its borders be apart
constexpr double kWidestGap = 5e-3;        // of a border, whatever tolerance the reader gives its corners
constexpr double kNearSide = 1e-2;         // share of the parameter range: at a pole all sides meet in space
constexpr double kWidestPart = 149.0 * std::numbers::pi / 180.0;  // of an arc in one patch [rad]
constexpr int kMostPieces = 400;                                  // of an approximated surface
constexpr int kLineTrials = 12;       // places of a line of division, until no corner is near it
constexpr double kLineStep = 7e-3;    // between them, share of the range
constexpr double kNearCorner = 2e-3;  // of a line, share of the range
constexpr int kInversionSteps = 20;   // Newton's, for a place on the spline; three suffice
constexpr double kInverted = 1e-15;   // share of the parameter range
constexpr double kAtPole = 1e-12;     // squared length of a tangent, of the longer one, at a pole

struct Rectangle {
  std::array<double, 2> u, v;
};

// Moves a value to a bound or knot that it nearly equals. Otherwise spans become slivers.
double snapped(double value, double range, const std::vector<double>& marks) {
  for (const double mark : marks)
    if (std::abs(value - mark) <= kSnapTolerance * range) return mark;
  return value;
}

void snap(const opencascade::handle<Geom_Surface>& surface, Rectangle& r) {
  std::vector<double> u(2), v(2);
  surface->Bounds(u[0], u[1], v[0], v[1]);
  if (const Spline spline = Spline::DownCast(surface); !spline.IsNull()) {
    for (const double knot : spline->UKnots()) u.push_back(knot);
    for (const double knot : spline->VKnots()) v.push_back(knot);
  }
  const double range_u = r.u[1] - r.u[0], range_v = r.v[1] - r.v[0];
  for (double& value : r.u) value = snapped(value, range_u, u);
  for (double& value : r.v) value = snapped(value, range_v, v);
}

Vec3 point_of(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

using Stretch = RegionCurve;  // of a wire, in the parameters of the surface
using Wire = RegionLoop;

// A face's surface with its wires, the outer one first.
struct Outline {
  Surface surface;
  std::vector<Wire> wires;
  double size = 0.0;       // of the borders [mm]
  double tolerance = 0.0;  // of their corners, as the file has it [mm]

  Vec3 at(const Vec2& p) const { return point_of(surface->Value(p.x(), p.y())); }
};

Wire wire_of(const CadPlace& place, const TopoDS_Wire& wire, const TopoDS_Face& face) {
  int edges = 0;
  for (TopExp_Explorer it(wire, TopAbs_EDGE); it.More(); it.Next()) ++edges;
  Wire out;
  for (BRepTools_WireExplorer it(wire, face); it.More(); it.Next()) {
    double from = 0.0, to = 0.0;
    const opencascade::handle<Geom2d_Curve> curve = BRep_Tool::CurveOnSurface(it.Current(), face, from, to);
    place.check(!curve.IsNull(), "has an edge without a curve in its parameters; export it again");
    if (it.Current().Orientation() == TopAbs_REVERSED) std::swap(from, to);
    out.push_back([curve, from, to](double t) {
      const gp_Pnt2d p = curve->Value(from + (to - from) * t);
      return Vec2(p.X(), p.Y());
    });
  }
  place.check(static_cast<int>(out.size()) == edges,
              "has a border of {} edges, of which {} make a loop; sew it in the CAD program", edges, out.size());
  return out;
}

// Moves a wire by whole periods of the surface to where `main` is.
void move_by_periods(const Surface& surface, const Wire& main, Wire& wire) {
  const Vec2 away = box_of(main).center() - box_of(wire).center();
  Vec2 shift = Vec2::Zero();
  if (surface->IsUPeriodic()) shift.x() = surface->UPeriod() * std::round(away.x() / surface->UPeriod());
  if (surface->IsVPeriodic()) shift.y() = surface->VPeriod() * std::round(away.y() / surface->VPeriod());
  if (shift.isZero(0.0)) return;
  for (Stretch& s : wire) s = [s, shift](double t) { return Vec2(s(t) + shift); };
}

// Throws Error where a wire is open.
void check_closed(const CadPlace& place, const Outline& out) {
  for (const Wire& wire : out.wires)
    for (std::size_t k = 0; k < wire.size(); ++k) {
      const Vec2 end = wire[k](1.0), next = wire[(k + 1) % wire.size()](0.0);
      const double gap = (out.at(end) - out.at(next)).norm();
      const Vec3 x = kMetresPerUnit * out.at(end);
      // OpenCASCADE widens the tolerance of corners until no border has a gap
      const double allowed =
          std::clamp(kCornerTolerances * out.tolerance, kTrimTolerance * out.size, kWidestGap * out.size);
      place.check(gap <= allowed,
                  "has a border with a gap of {:.3g} m at ({:.4g}, {:.4g}, {:.4g}) m, and {:.3g} m are allowed; sew it "
                  "in the CAD program",
                  kMetresPerUnit * gap, x.x(), x.y(), x.z(), kMetresPerUnit * allowed);
    }
}

Outline outline_of(const CadPlace& place, const TopoDS_Face& face, double filled) {
  Outline out{BRep_Tool::Surface(face), {}, 0.0, 0.0};
  for (TopExp_Explorer it(face, TopAbs_VERTEX); it.More(); it.Next())
    out.tolerance = std::max(out.tolerance, BRep_Tool::Tolerance(TopoDS::Vertex(it.Current())));
  place.check(!out.surface.IsNull(), "has no surface, a mesh perhaps; export the surface itself");
  for (TopExp_Explorer it(face, TopAbs_WIRE); it.More(); it.Next())
    if (Wire wire = wire_of(place, TopoDS::Wire(it.Current()), face); !wire.empty())
      out.wires.push_back(std::move(wire));
  if (out.wires.empty()) return out;
  std::stable_sort(out.wires.begin(), out.wires.end(),
                   [](const Wire& a, const Wire& b) { return std::abs(area_of(a)) > std::abs(area_of(b)); });
  const auto extent = [&](const Wire& wire) {
    Eigen::AlignedBox3d box;  // [mm]
    each_sample(wire, [&](const Stretch& s, double t) { box.extend(out.at(s(t))); });
    return box.sizes();
  };
  out.size = extent(out.wires[0]).norm();
  for (std::size_t k = out.wires.size() - 1; k > 0; --k)
    if (kMetresPerUnit * extent(out.wires[k]).maxCoeff() <= filled)
      out.wires.erase(out.wires.begin() + static_cast<std::ptrdiff_t>(k));
    else
      move_by_periods(out.surface, out.wires[0], out.wires[k]);
  check_closed(place, out);
  if (area_of(out.wires[0]) < 0.0)  // regions lie on the left of their borders
    for (Wire& wire : out.wires) {
      std::reverse(wire.begin(), wire.end());
      for (Stretch& s : wire) s = [s](double t) { return s(1.0 - t); };
    }
  return out;
}

Rectangle rectangle_of(const CadPlace& place, const Outline& o) {
  Rectangle r;
  if (o.wires.empty()) {
    o.surface->Bounds(r.u[0], r.u[1], r.v[0], r.v[1]);
    for (const double bound : {r.u[0], r.u[1], r.v[0], r.v[1]})
      place.check(!Precision::IsInfinite(bound), "has no end; give it borders in the CAD program");
    return r;
  }
  const Eigen::AlignedBox2d box = box_of(o.wires[0]);
  r = {{box.min().x(), box.max().x()}, {box.min().y(), box.max().y()}};
  snap(o.surface, r);
  double u0, u1, v0, v1;
  o.surface->Bounds(u0, u1, v0, v1);  // borders may lie beyond the surface by the tolerance of the file
  if (!o.surface->IsUPeriodic()) r.u = {std::max(r.u[0], u0), std::min(r.u[1], u1)};
  if (!o.surface->IsVPeriodic()) r.v = {std::max(r.v[0], v0), std::min(r.v[1], v1)};
  return r;
}

// The smallest rectangle around a part, within the one by which it was cut.
Rectangle shrunk(const CadPlace& place, const Outline& part, const Rectangle& by) {
  if (part.wires.empty()) return by;
  Rectangle r = rectangle_of(place, part);
  r.u = {std::max(r.u[0], by.u[0]), std::min(r.u[1], by.u[1])};
  r.v = {std::max(r.v[0], by.v[0]), std::min(r.v[1], by.v[1])};
  return r;
}

// Whether both ends of a range along `axis` are the same curve, to `tolerance` [mm].
bool closes(const Surface& surface, double tolerance, int axis, const std::array<double, 2>& range,
            const std::array<double, 2>& across) {
  constexpr int kPlaces = 5;
  for (int k = 0; k <= kPlaces; ++k) {
    const double other = across[0] + (across[1] - across[0]) * k / kPlaces;
    const auto at = [&](double own) { return axis == 0 ? surface->Value(own, other) : surface->Value(other, own); };
    if (at(range[0]).Distance(at(range[1])) > tolerance) return false;
  }
  return true;
}

// Lines of constant parameter by which a face is divided: an arc of a patch is short, and no patch closes on itself or
// has a crease.
std::vector<double> lines_along(const Surface& surface, double tolerance, int axis, const std::array<double, 2>& range,
                                const std::array<double, 2>& across) {
  const GeomAdaptor_Surface kind(surface);
  const GeomAbs_SurfaceType type = kind.GetType();
  const bool round = type == GeomAbs_Cylinder || type == GeomAbs_Cone || type == GeomAbs_SurfaceOfRevolution;
  const bool angle =
      type == GeomAbs_Sphere || type == GeomAbs_Torus || (round && axis == 0) ||
      (type == GeomAbs_SurfaceOfExtrusion && axis == 0 && kind.BasisCurve()->GetType() == GeomAbs_Circle);
  const auto parts = [&](int count) {
    std::vector<double> out;
    for (int k = 1; k < count; ++k) out.push_back(range[0] + (range[1] - range[0]) * k / count);
    return out;
  };
  if (angle) return parts(static_cast<int>(std::ceil((range[1] - range[0]) / kWidestPart - kSnapTolerance)));
  if (const Spline spline = Spline::DownCast(surface); !spline.IsNull()) {
    const bool u = axis == 0;
    std::vector<double> creases;
    const int degree = u ? spline->UDegree() : spline->VDegree();
    for (int k = 2; k < (u ? spline->NbUKnots() : spline->NbVKnots()); ++k) {
      const double at = u ? spline->UKnot(k) : spline->VKnot(k);
      if ((u ? spline->UMultiplicity(k) : spline->VMultiplicity(k)) < degree || at <= range[0] || at >= range[1])
        continue;
      const Spline trial = Spline::DownCast(spline->Copy());
      if (u ? !trial->RemoveUKnot(k, degree - 1, tolerance) : !trial->RemoveVKnot(k, degree - 1, tolerance))
        creases.push_back(at);
    }
    if (!creases.empty()) return creases;
  }
  return closes(surface, tolerance * kTrimTolerance / kSmoothTolerance, axis, range, across) ? parts(3)
                                                                                             : std::vector<double>{};
}

// A part of a face: the region and the rectangle that it is cut from.
struct Part {
  Region region;
  Rectangle r;
};

// Divides a face until each part is one patch.
std::vector<Part> parts_of(const CadPlace& place, const Outline& o, const Rectangle& r) {
  std::vector<Part> parts{{o.wires, r}};
  for (int axis = 0; axis < 2; ++axis) {
    const std::array<double, 2>& range = axis == 0 ? r.u : r.v;
    for (double at :
         lines_along(o.surface, kSmoothTolerance * std::max(1.0, o.size), axis, range, axis == 0 ? r.v : r.u)) {
      const bool crease = !Spline::DownCast(o.surface).IsNull();
      for (int k = 0;
           k < kLineTrials && !crease && !crosses_cleanly(o.wires, axis, at, kNearCorner * (range[1] - range[0])); ++k)
        at += kLineStep * (range[1] - range[0]);
      std::vector<Part> divided;
      for (const Part& part : parts) {
        const std::array<double, 2>& own = axis == 0 ? part.r.u : part.r.v;
        if (at <= own[0] || at >= own[1]) {
          divided.push_back(part);
          continue;
        }
        for (const bool below : {true, false}) {
          Part half{{}, part.r};
          (axis == 0 ? half.r.u : half.r.v)[below ? 1 : 0] = at;
          if (part.region.empty()) {
            divided.push_back(half);
            continue;
          }
          try {
            for (Region& region : connected(part_of(part.region, axis, at, below))) divided.push_back({region, half.r});
          } catch (const Error& e) {
            place.check(false, "cannot be divided: {}", e.what());
          }
        }
      }
      parts = std::move(divided);
    }
  }
  return parts;
}

// Distance in space [mm] of a parameter point from a side of the rectangle: EdgeBit `side`.
double off_side(const Outline& o, const Rectangle& r, const Vec2& p, int side) {
  Vec2 on = p;
  on[side == kUMin || side == kUMax ? 0 : 1] = side == kUMin   ? r.u[0]
                                               : side == kUMax ? r.u[1]
                                               : side == kVMin ? r.v[0]
                                                               : r.v[1];
  return (o.at(p) - o.at(on)).norm();
}

bool fills_rectangle(const Outline& o, const Rectangle& r) {
  bool fills = true;
  each_sample(o.wires[0], [&](const Stretch& s, double t) {
    double off = 1e300;
    for (const int side : kEdges) off = std::min(off, off_side(o, r, s(t), side));
    fills = fills && off <= kTrimTolerance * o.size;
  });
  return fills;
}

// EdgeBits of the sides on which a stretch runs.
int sides_of(const Outline& o, const Rectangle& r, const Stretch& s) {
  int sides = 0;
  for (const int side : kEdges) {
    const int axis = side == kUMin || side == kUMax ? 0 : 1;
    const std::array<double, 2>& range = axis == 0 ? r.u : r.v;
    const double at = side == kUMin || side == kVMin ? range[0] : range[1];
    bool on = true;
    for (int i = 0; i < kRegionSamples && on; ++i) {
      const Vec2 p = s(static_cast<double>(i) / (kRegionSamples - 1));
      on = std::abs(p[axis] - at) <= kNearSide * (range[1] - range[0]) &&
           off_side(o, r, p, side) <= kTrimTolerance * o.size;
    }
    if (on) sides |= side;
  }
  return sides;
}

// Prepares the u direction: open knots, two free ends, no more knots than a smooth surface needs.
void prepare_u(const CadPlace& place, const Spline& s, double size, const char* direction) {
  if (s->IsUPeriodic()) s->SetUNotPeriodic();
  const int degree = s->UDegree(), last = s->NbUKnots();
  if (s->UMultiplicity(1) <= degree || s->UMultiplicity(last) <= degree) {  // the knot vector is not open
    double u0, u1, v0, v1;
    s->Bounds(u0, u1, v0, v1);
    s->Segment(u0, u1, v0, v1);
  }
  bool closed = true;
  for (int j = 1; j <= s->NbVPoles(); ++j)
    closed = closed && s->Pole(1, j).Distance(s->Pole(s->NbUPoles(), j)) <= kTrimTolerance * size;
  place.check(!closed, "closes on itself along {}, and a patch would be slit there; split it in the CAD program",
              direction);
  for (int k = s->NbUKnots() - 1; k > 1; --k) {
    const double share = (s->UKnot(k) - s->UKnot(1)) / (s->UKnot(s->NbUKnots()) - s->UKnot(1));
    place.check(s->UMultiplicity(k) < degree || s->RemoveUKnot(k, degree - 1, kSmoothTolerance * size),
                "has a crease, or an arc of 150 degrees or more in pieces, across {} at {:.4g} of its range (a knot "
                "{} times at degree {}); bending needs a smooth surface: split the face there in the CAD program",
                direction, share, s->UMultiplicity(k), degree);
  }
}

// The surface over a rectangle; `error` receives how far an approximation is off [mm], 0 for an exact one.
Spline to_spline(const CadPlace& place, const Surface& surface, const Rectangle& r, double size, double& error) {
  const Surface part = new Geom_RectangularTrimmedSurface(surface, r.u[0], r.u[1], r.v[0], r.v[1]);
  Spline s = GeomConvert::SurfaceToBSplineSurface(part);
  const int high = std::max(s->UDegree(), s->VDegree());
  if (high > kHighestDegree) {
    const double allowed = kApproximated * size;
    GeomConvert_ApproxSurface fit(part, allowed, GeomAbs_C1, GeomAbs_C1, kHighestDegree, kHighestDegree, kMostPieces,
                                  1);
    place.check(fit.HasResult() && fit.MaxError() <= allowed,
                "has degree {} along u and {} along v; no spline of degree {} is within {:.3g} m of it: rebuild the "
                "surface in the CAD program",
                s->UDegree(), s->VDegree(), kHighestDegree, kMetresPerUnit * allowed);
    s = fit.Surface(), error = fit.MaxError();
  }
  const int degree = std::max({2, s->UDegree(), s->VDegree()});
  s->IncreaseDegree(degree, degree);
  Eigen::AlignedBox3d box;
  for (int j = 1; j <= s->NbVPoles(); ++j)
    for (int i = 1; i <= s->NbUPoles(); ++i) box.extend(point_of(s->Pole(i, j)));
  for (const char* direction : {"u", "v"}) {
    prepare_u(place, s, box.diagonal().norm(), direction);
    s->ExchangeUV();  // the second exchange restores the order
  }
  return s;
}

Patch to_patch(const Spline& s, double scale, const std::string& path) {
  const int degree = s->UDegree();  // the same for v
  const auto knots = [degree](const TColStd_Array1OfReal& k, const char* name) {
    return KnotVector({k.begin(), k.end()}, degree, name);
  };
  Patch patch{knots(s->UKnotSequence(), "knots along u"), knots(s->VKnotSequence(), "knots along v"), {}, {}};
  for (int j = 1; j <= s->NbVPoles(); ++j)
    for (int i = 1; i <= s->NbUPoles(); ++i) {
      const gp_Pnt p = s->Pole(i, j);
      patch.control_points.push_back(scale * Vec3(p.X(), p.Y(), p.Z()));
      patch.weights.push_back(s->Weight(i, j));
    }
  validate(patch, path);
  return patch;
}

// Finds places of the surface on the patch. Arcs have another parameter there, so Newton's method looks for them.
struct Inversion {
  Surface surface;
  Rectangle r;
  double scale;  // metres per unit of the surface
  bool turned;   // u and v of the patch are v and u of the surface
  Patch patch;

  Vec2 place(const Vec2& from) const {
    const gp_Pnt q = surface->Value(from.x(), from.y());
    const Vec3 x = scale * point_of(q);
    const Vec2 low(patch.knots_u.begin(), patch.knots_v.begin()), high(patch.knots_u.end(), patch.knots_v.end());
    Vec2 share((from.x() - r.u[0]) / (r.u[1] - r.u[0]), (from.y() - r.v[0]) / (r.v[1] - r.v[0]));
    if (turned) std::swap(share.x(), share.y());
    const auto inside = [&](const Vec2& p) { return Vec2(p.cwiseMax(low).cwiseMin(high)); };
    Vec2 p = inside(low + share.cwiseProduct(high - low));
    for (int k = 0; k < kInversionSteps; ++k) {
      const SurfacePoint s = patch.evaluate(p);
      const Vec3 away = x - s.x;
      const double uu = s.u.squaredNorm(), uv = s.u.dot(s.v), vv = s.v.squaredNorm(), most = std::max(uu, vv);
      Vec2 step = Vec2::Zero();
      if (uu <= kAtPole * most)
        step.y() = s.v.dot(away) / vv;
      else if (vv <= kAtPole * most)
        step.x() = s.u.dot(away) / uu;
      else
        step = Vec2(vv * s.u.dot(away) - uv * s.v.dot(away), uu * s.v.dot(away) - uv * s.u.dot(away)) /
               (uu * vv - uv * uv);
      const Vec2 next = inside(p + step);
      const double moved = (next - p).cwiseQuotient(high - low).cwiseAbs().maxCoeff();
      p = next;
      if (!(moved > kInverted)) break;
    }
    return p;
  }
};

PlaneCurve curve_of(const std::shared_ptr<const Inversion>& inversion, const Stretch& s) {
  PlaneCurve curve;
  curve.at = [inversion, s](double t) { return inversion->place(s(t)); };
  for (int i = 1; i < kRegionSamples; ++i)
    curve.length +=
        (curve.at(static_cast<double>(i) / (kRegionSamples - 1)) - curve.at((i - 1.0) / (kRegionSamples - 1))).norm();
  return curve;
}

// EdgeBits with u and v swapped.
int turned(int sides) {
  return (sides & kUMin ? kVMin : 0) | (sides & kUMax ? kVMax : 0) | (sides & kVMin ? kUMin : 0) |
         (sides & kVMax ? kUMax : 0);
}

// OpenCASCADE's fixed rule passes over knots of borders, its adaptive one is so far off. Agreed, the former counts.
constexpr double kAreaError = 1e-7;  // share of the area

// Area [mm^2]. Throws Error where a face is as narrow as its border is thick: no border could be told from the other.
double checked_area(const CadPlace& place, const TopoDS_Face& face, const Outline& o) {
  GProp_GProps fixed, adaptive;
  BRepGProp::SurfaceProperties(face, fixed), BRepGProp::SurfaceProperties(face, adaptive, kAreaError);
  const double a = std::abs(fixed.Mass()), b = std::abs(adaptive.Mass()), area = std::abs(a - b) > 1e-6 * b ? b : a;
  double border = 0.0;
  for (const Wire& wire : o.wires)
    for (const Stretch& s : wire)
      for (int i = 1; i < kRegionSamples; ++i)
        border += (o.at(s(i / (kRegionSamples - 1.0))) - o.at(s((i - 1) / (kRegionSamples - 1.0)))).norm();
  const double width = border > 0.0 ? 2.0 * area / border : o.size;
  place.check(o.wires.empty() || width > kTrimTolerance * o.size,
              "has an area of {:.3g} m^2 within a border of {:.3g} m: a sliver; remove it in the CAD program, or leave "
              "it out by `faces`, with seams.tolerance_m of {:.2g} m or more where its neighbours are to be joined",
              kMetresPerUnit * kMetresPerUnit * area, kMetresPerUnit * border,
              kMetresPerUnit * std::max(2.0 * width, kTrimTolerance * o.size));
  return area;
}

}  // namespace

std::vector<CadSurface> convert_face(const CadPlace& place, const TopoDS_Face& face, double scale, double filled) {
  Outline whole = outline_of(place, TopoDS::Face(face.Oriented(TopAbs_FORWARD)), filled);
  const bool reversed = face.Orientation() == TopAbs_REVERSED;
  const double metres = kMetresPerUnit * scale;
  std::vector<CadSurface> out;
  const Rectangle around = rectangle_of(place, whole);
  const double area = checked_area(place, face, whole);
  const std::vector<Part> parts = parts_of(place, whole, around);
  for (const Part& part : parts) {
    const Outline outline{whole.surface, part.region, whole.size, whole.tolerance};
    const Rectangle r = shrunk(place, outline, part.r);
    double error = 0.0;
    const Spline s = to_spline(place, outline.surface, r, std::max(1.0, whole.size), error);
    if (reversed) s->ExchangeUV();  // u cross v is the face's normal
    CadSurface surface{to_patch(s, metres, place.path), {}, 0.0, metres * error};
    const auto inversion =
        std::make_shared<const Inversion>(Inversion{outline.surface, r, metres, reversed, surface.patch});
    for (std::size_t k = 0; k < outline.wires.size(); ++k) {
      if (k == 0 && fills_rectangle(outline, r)) continue;
      CadLoop loop{{}, k > 0};
      for (const Stretch& stretch : outline.wires[k]) {
        const int sides = sides_of(outline, r, stretch);
        loop.borders.push_back({curve_of(inversion, stretch), reversed ? turned(sides) : sides});
      }
      surface.loops.push_back(std::move(loop));
    }
    out.push_back(std::move(surface));
  }
  for (CadSurface& surface : out) surface.area = area * metres * metres;
  return out;
}

}  // namespace sunder::shell

#endif
