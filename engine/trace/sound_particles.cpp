#include "engine/trace/sound_particles.h"

#include <algorithm>

#include "engine/rays/follow_rays.h"

namespace aula {

namespace {

/// Particles that one job moves, and that one query of the scene intersects. A choice: a population
/// has sixteen jobs.
constexpr std::size_t kBlock = 64;

/// Multiplies the energy by `share` and chooses the diffuse or the specular lobe for all bands
/// (Embrechts 2000), as PathBatch does. Returns true for the diffuse lobe.
bool take_lobe(const Bands& share, const Bands& scattering, float choice, Bands& energy) {
    energy *= share;
    const Bands scattered = energy * scattering;
    const float total = energy.sum();
    const float diffuse = scattered.sum();
    if (!(total > 0)) return false;
    if (choice * total < diffuse) {
        energy = scattered * (total / diffuse);
        return true;
    }
    energy = energy * complement(scattering) * (total / (total - diffuse));
    return false;
}

void end(SoundParticle& particle) { particle.energy = {}; }

bool has_ended(const SoundParticle& particle) { return !(particle.energy.max() > 0); }

}  // namespace

SoundParticles::SoundParticles(const RayScene& scene, int order, const Vec3& start,
                               std::size_t count, std::uint64_t seed)
    : scene_(scene), order_(order), seed_(seed), particles_(count) {
    const ScrambledSobol sobol(seed);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < count; ++i) {
        SoundParticle& particle = particles_[i];
        particle.segment = {start, uniform_direction(sobol.point(static_cast<std::uint32_t>(i)))};
        particle.energy = Bands::filled(1.0F / static_cast<float>(count));
        particle.random = RandomStream(derive_seed(seed, i));
        rays.push_back(particle.segment);
    }
    std::vector<Hit> hits(count);
    scene.intersect(rays, hits);
    for (std::size_t i = 0; i < count; ++i) particles_[i].hit = hits[i];
}

void SoundParticles::advance(float distance_m, WorkerPool& workers) {
    workers.run((particles_.size() + kBlock - 1) / kBlock, [&](std::size_t job) {
        const std::size_t first = job * kBlock;
        const std::size_t count = std::min(kBlock, particles_.size() - first);
        advance(std::span(particles_).subspan(first, count), distance_m);
    });
}

void SoundParticles::advance(std::span<SoundParticle> block, float distance_m) const {
    std::vector<WallExit> exits;
    // True if the particle has been reflected, so that the end of its next segment is unknown.
    const auto reflected = [&](SoundParticle& particle) {
        if (has_ended(particle)) return false;
        if (!particle.hit.any()) {
            end(particle);
            return false;
        }
        if (particle.travelled_m < particle.hit.distance_m) return false;
        reflect(particle, exits);
        return !has_ended(particle);
    };
    std::vector<SoundParticle*> at_surfaces;
    for (SoundParticle& particle : block) {
        particle.travelled_m += distance_m;
        if (reflected(particle)) at_surfaces.push_back(&particle);
    }
    follow_rays(
        scene_, at_surfaces, [](const SoundParticle* particle) { return particle->segment; },
        [&](SoundParticle* particle, const Ray&, const Hit& hit) {
            particle->hit = hit;
            return reflected(*particle);
        });
}

/// Begins the next segment at the hit, or behind the wall. `exits` is memory that is used again.
void SoundParticles::reflect(SoundParticle& particle, std::vector<WallExit>& exits) const {
    if (order_ > 0 && particle.reflections == order_) return end(particle);
    ++particle.reflections;
    const Hit hit = particle.hit;
    const Vec3 direction = particle.segment.direction;
    const RayScene::Surface& surface = scene_.surface(hit.triangle);
    const Vec3 normal = scene_.facing_normal(hit, direction);
    const float cosine = -glm::dot(direction, normal);
    const auto point_at = [&](const RayScene::PointOff& at) {
        return particle.segment.origin + at.along_m * direction + at.off_m * normal;
    };
    const auto choices = particle.random.uniform_2d();
    const auto lobe = particle.random.uniform_2d();
    particle.travelled_m -= hit.distance_m;
    float weight = 1;
    if (scene_.transmits(surface.material)) {
        const WallEntry entry{hit, point_at(RayScene::point_beyond(hit.distance_m, cosine)),
                              normal};
        find_wall_exits(scene_, {&entry, 1}, exits);
        if (exits[0].wall.transmission.max() > 0) {
            weight = 2;  // half of the particles pass
            if (choices[0] < 0.5F) {
                const WallTransmission& wall = exits[0].wall;
                const bool diffuse = take_lobe(wall.transmission * weight, wall.scattering,
                                               choices[1], particle.energy);
                particle.segment = {exits[0].point,
                                    diffuse ? lambert_direction(exits[0].normal, lobe) : direction};
                return;
            }
        }
    }
    const Material& material = scene_.material(surface.material);
    const bool diffuse = take_lobe(complement(material.absorption) * weight, material.scattering,
                                   choices[1], particle.energy);
    particle.segment = {point_at(RayScene::point_off(hit.distance_m, cosine)),
                        diffuse ? lambert_direction(normal, lobe) : mirror(direction, normal)};
}

void SoundParticles::choose(std::span<const double> importance) {
    // The usual bound of particle filters: an effective number of half the population.
    constexpr double kEnough = 0.5;
    double sum = 0;
    double squares = 0;
    for (const double x : importance) {
        sum += x;
        squares += x * x;
    }
    const auto count = static_cast<double>(particles_.size());
    if (!(sum > 0) || sum * sum >= kEnough * count * squares) return;
    ++choices_;
    const double step = sum / count;
    double next = double{RandomStream(derive_seed(seed_, choices_, 0)).uniform()} * step;
    double passed = 0;
    std::vector<SoundParticle> chosen;
    chosen.reserve(particles_.size());
    for (std::size_t i = 0; i < particles_.size(); ++i) {
        passed += importance[i];
        for (; next < passed && chosen.size() < particles_.size(); next += step) {
            SoundParticle copy = particles_[i];
            copy.energy *= static_cast<float>(step / importance[i]);
            copy.random = RandomStream(derive_seed(seed_, choices_, chosen.size() + 1));
            chosen.push_back(copy);
        }
    }
    particles_ = std::move(chosen);
}

}  // namespace aula
