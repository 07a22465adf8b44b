#include "apps/room/auralizer/command_checks.h"

#include <cmath>
#include <string>

#include "apps/room/base/output_resources.h"
#include "aula/exception.h"
#include "engine/scene/scene_values.h"

namespace aula {

namespace {

constexpr float kHighestGain_db = 200;

/// Rounding of a rotation that a host has composed in single precision.
constexpr float kRigidTolerance = 1e-2F;

bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

void require(bool holds, const char* otherwise) {
    if (!holds) throw InputError(std::string("auralizer: ") + otherwise);
}

void check_options(const AuralizerOptions& options) {
    check_output(options, "auralizer");
    require(options.listeners >= 1, "there is no listener");
}

void check_position(const Vec3& position) {
    // The comparison also fails for NaN.
    for (const float x : {position.x, position.y, position.z})
        require(std::abs(x) <= kLargestCoordinate_m, "a position is not within -1e6 to 1e6 m");
}

void check_pose(const Pose& pose) {
    check_position(pose.position);
    require(is_finite({pose.yaw_rad, pose.pitch_rad, pose.roll_rad}), "an angle is not finite");
}

void check_gain(float gain_db) {
    require(gain_db <= kHighestGain_db, "a gain is not a number up to 200 dB");
}

void check_transform(const RigidTransform& transform) {
    require(is_finite(transform.translation), "a transform's translation is not finite");
    const glm::mat3 identity = glm::transpose(transform.rotation) * transform.rotation;
    bool rigid = glm::determinant(transform.rotation) > 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
            rigid = rigid && std::abs(identity[c][r] - (c == r ? 1.0F : 0.0F)) < kRigidTolerance;
    require(rigid, "a transform's rotation is not one: its columns are not orthonormal");
}

void check_material(const Material& material) {
    for (std::size_t b = 0; b < kBandCount; ++b) {
        for (const float share : {material.absorption[b], material.scattering[b]})
            require(share >= 0 && share <= 1, "a coefficient of a material is not from 0 to 1");
        if (!material.sound_reduction_db) continue;
        const float reduction_db = (*material.sound_reduction_db)[b];
        require(reduction_db >= 0 && reduction_db <= Material::kHighestSoundReduction_db,
                "a sound reduction index is not from 0 to 120 dB");
        require(!material.transmits_too_much(b),
                "a material transmits more energy than it absorbs");
    }
}

void check_part_gains(const PartGains& gains) {
    for (const float gain : {gains.direct, gains.early, gains.late})
        require(gain >= 0 && std::isfinite(gain), "a gain of a part is not a number from 0 on");
}

}  // namespace aula
