// Presets of materials: their values stand beside their names, in proto/scene.proto.
#include "coupler/scene/presets.h"

namespace sunder::scene {

void fill_presets(proto::Scene& scene) {
  for (proto::Material& m : *scene.mutable_materials()) {
    const auto* preset = proto::Material::Preset_descriptor()->FindValueByNumber(m.preset());
    if (preset == nullptr || !preset->options().HasExtension(proto::preset_values)) continue;
    proto::Material filled = preset->options().GetExtension(proto::preset_values);
    filled.MergeFrom(m);  // what the scene gives stays
    m = filled;
  }
}

}  // namespace sunder::scene
