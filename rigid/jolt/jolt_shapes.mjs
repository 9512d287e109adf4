// Makes Jolt's shapes.
import { rejectBody } from './failure.mjs';

/** Units in Jolt: lengths in cm, masses in g. Jolt's tolerances suit sizes of some units, and shards measure some
 * centimetres. */
export const kLength = 100; // [1/m]
export const kMass = 1000; // [1/kg]

/** Largest rounding radius of edges and corners, inside the shape's size. */
const kRounding = 0.03; // [cm]
/** Largest share of a box's smallest half size that is rounded. */
const kRoundedShare = 0.45;
/** A corner nearer to a face than this counts as in it. The smaller values are for slivers. */
const kHullTolerances = [1e-3, 1e-4, 1e-5]; // [cm]
/** Share of (diagonal of the bounds)^3 below which a hull is flat. */
const kFlatShare = 1e-12;
const kHalfSpaceExtent = 1e5; // [cm]

function hasVolume(shape) {
  const size = shape.GetLocalBounds().GetSize();
  return shape.GetVolume() > kFlatShare * Math.hypot(size.GetX(), size.GetY(), size.GetZ()) ** 3;
}

/** Makes shapes with their origin in the body's centre of mass. */
export class Shapes {
  constructor(jolt) {
    this.jolt = jolt;
    this.vector = new jolt.Vec3(0, 0, 0);
    this.upright = new jolt.Quat(0, 0, 0, 1);
  }

  /** Shape of a body. Throws Failure (bad_body) where Jolt cannot hold it. */
  make(body) {
    const { jolt } = this;
    const { sphere, box, half_space: halfSpace, parts } = body.shape;
    if (sphere) return this.create(new jolt.SphereShapeSettings(kLength * sphere), body, 'shape.radius');
    if (box) {
      const rounding = Math.min(kRounding, kRoundedShare * kLength * Math.min(...box));
      return this.create(new jolt.BoxShapeSettings(this.point(box), rounding), body, 'shape.half_size');
    }
    if (halfSpace) {
      if (!body.is_static) rejectBody(body, 'shape', 'is a half space that moves; make it static or use a box');
      const plane = new jolt.Plane(this.set(0, 0, 1), 0);
      const settings = new jolt.PlaneShapeSettings(plane);
      settings.mHalfExtent = kHalfSpaceExtent;
      return this.create(settings, body, 'shape');
    }
    const hulls = parts.map((part, index) => this.hull(part, body, `shape.parts[${index}]`));
    if (hulls.length === 1) return this.centred(hulls[0], body);
    const compound = new jolt.StaticCompoundShapeSettings();
    for (const hull of hulls) compound.AddShapeShapeSettings(this.set(0, 0, 0), this.upright, hull, 0);
    return this.centred(compound, body);
  }

  /** Settings of a convex hull. Throws Failure (bad_body) where it is flat. */
  hull(corners, body, field) {
    let said = '';
    for (const tolerance of kHullTolerances) {
      const settings = new this.jolt.ConvexHullShapeSettings();
      for (const corner of corners) settings.mPoints.push_back(this.point(corner));
      settings.mMaxConvexRadius = kRounding;
      settings.mMaxErrorConvexRadius = kRounding;
      settings.mHullTolerance = tolerance;
      const result = settings.Create();
      if (!result.HasError() && hasVolume(result.Get())) return settings;
      said = result.HasError() ? result.GetError().c_str() : 'it is flat';
      this.jolt.destroy(settings);
    }
    return rejectBody(body, field,
      `is no hull (${corners.length} corners): ${said}; leave flat parts out, thin fine ones`);
  }

  centred(settings, body) {
    const centre = settings.Create().Get().GetCenterOfMass();
    const back = this.set(-centre.GetX(), -centre.GetY(), -centre.GetZ());
    return this.create(new this.jolt.OffsetCenterOfMassShapeSettings(back, settings), body, 'shape');
  }

  create(settings, body, field) {
    const result = settings.Create();
    if (result.HasError()) rejectBody(body, field, `is refused: ${result.GetError().c_str()}`);
    const shape = result.Get();
    shape.AddRef();
    settings.AddRef();
    settings.Release(); // also frees what they refer to
    return shape;
  }

  set(x, y, z) {
    this.vector.Set(x, y, z);
    return this.vector;
  }

  point(p) {
    return this.set(kLength * p[0], kLength * p[1], kLength * p[2]);
  }
}
