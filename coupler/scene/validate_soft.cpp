// Checks soft bodies.
#include <cmath>

#include "coupler/scene/checks.h"
#include "coupler/scene/mesh.h"
#include "coupler/scene/names.h"

namespace sunder::scene {
namespace {

constexpr double kLeastGrid = 1.5, kMostGrid = 4.0;  // of the particles' spacing

bool is_soft(const LoadedScene& s, const std::string& name) {
  for (const proto::SoftBody& b : s.message.soft_bodies())
    if (b.name() == name) return true;
  return false;
}

void soft_body(const LoadedScene& s, const std::string& f, const proto::SoftBody& b) {
  const proto::Material* found = nullptr;
  for (const proto::Material& m : s.message.materials())
    if (m.name() == b.material()) found = &m;
  if (!found) refuse_name(s, f + ".material", b.material(), "material", names_in(s.message.materials()));
  s.check(found->has_youngs_modulus() && found->has_poisson_ratio(), f + ".material",
          "'{}' has no youngs_modulus or poisson_ratio; a soft body needs both", b.material());
  s.check(
      found->poisson_ratio() >= 0.0, f + ".material",
      "'{}' has a poisson_ratio of {}; a soft body's is 0 or more: below, the energy of its law falls without bound "
      "as it is squeezed",
      b.material(), found->poisson_ratio());
  for (const auto& [given, name] :
       {std::pair{found->has_strength(), "strength"}, std::pair{found->has_yield_stress(), "yield_stress"},
        std::pair{found->has_mass_damping_per_s(), "mass_damping_per_s"},
        std::pair{found->has_stiffness_damping_s(), "stiffness_damping_s"}})
    s.check(!given, f + ".material", "'{}' has a {}, which soft bodies cannot have; name a material without it",
            b.material(), name);
  s.check(b.shape_case() != proto::SoftBody::SHAPE_NOT_SET, f, "has no shape; give sphere, box or mesh");
  if (b.has_sphere()) positive(s, f + ".sphere.radius_m", b.sphere().has_radius_m(), b.sphere().radius_m(), "m");
  if (b.has_box())
    for (const double edge : {b.box().size_m().x(), b.box().size_m().y(), b.box().size_m().z()})
      positive(s, f + ".box.size_m", b.box().has_size_m(), edge, "m");
  if (b.has_mesh()) {
    s.check(b.mesh().surface() == proto::Mesh::HULL, f + ".mesh.surface",
            "is EXACT, which is for rigid bodies; a soft body takes the HULL of its points");
    read_mesh(s, f + ".mesh", b.mesh());
  }
  pose(s, f + ".pose", b.pose());
  finite(s, f + ".twist.linear", b.twist().linear());
  finite(s, f + ".twist.angular", b.twist().angular());
  positive(s, f + ".spacing_m", b.has_spacing_m(), b.spacing_m(), "m");
  const double ratio = b.grid_spacing_m() / b.spacing_m();
  s.check(!b.has_grid_spacing_m() || (ratio >= kLeastGrid * (1.0 - 1e-9) && ratio <= kMostGrid * (1.0 + 1e-9)),
          f + ".grid_spacing_m", "is {} m, {:.3g} times spacing_m; {} to {} times, 2 unless there is a reason",
          b.grid_spacing_m(), ratio, kLeastGrid, kMostGrid);
}

}  // namespace

void validate_soft(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  if (m.soft_bodies_size() == 0) return;
  for (int i = 0; i < m.soft_bodies_size(); ++i) soft_body(s, fmt::format("soft_bodies[{}]", i), m.soft_bodies(i));
  for (int i = 0; i < m.contacts_size(); ++i) {
    const proto::ContactPair& c = m.contacts(i);
    const std::string f = fmt::format("contacts[{}]", i);
    if (!is_soft(s, c.first()) && !is_soft(s, c.second())) continue;
    s.check(c.first() != c.second(), f + ".second",
            "is '{}' as well, and a soft body touches itself by its own grid; leave the pair out", c.second());
    s.check(!c.has_restitution() || c.restitution() == 0.0, f + ".restitution",
            "is {}, but soft bodies bounce by their elasticity alone; leave it out", c.restitution());
  }
  for (int i = 0; i < m.bodies_size(); ++i)
    s.check(!is_soft(s, m.bodies(i).launch().target()), fmt::format("bodies[{}].launch.target", i),
            "'{}' is a soft body; name a shell or a rigid body, or give the twist", m.bodies(i).launch().target());
  s.check(!m.fracture().has_latest_freeze_s(), "fracture.latest_freeze_s",
          "would freeze the shells before end_time_s, while soft bodies still touch them; leave it out");
  s.check(m.coupling().scheme() == proto::Coupling::PROXY || m.coupling().scheme() == proto::Coupling::EXPORTED,
          "coupling.scheme", "is {}, which soft bodies exclude; take PROXY or EXPORTED",
          proto::Coupling::Scheme_Name(m.coupling().scheme()));
}

}  // namespace sunder::scene
