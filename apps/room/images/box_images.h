#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/scene.h"

namespace aula {

/// All image sources of an empty box whose walls scatter nothing, up to the length of the response:
/// the exact field (Allen and Berkley 1979), without rays and their noise. [several threads]
class BoxImages {
 public:
    /// Empty if the scene is anything else than such a box, if its settings ask for other paths
    /// than all, if a source or receiver is not in it, or if there are too many images.
    static std::optional<BoxImages> find(const Scene& scene, std::span<const Pose> receivers,
                                         double length_s);

    /// Of a pair, and of all pairs if a pair has more. Beyond these a response of many takes longer
    /// than by rays, and a single one longer than 4 s of a core, of 16 channels 8 s. A single
    /// response may thus last 1.0 s in 10 m3 and 2.1 s in 100 m3.
    static constexpr double kMostImages = 4e6;
    static constexpr double kMostOfAllPairs = 1.6e7;

    /// Images up to Simulation::specular_order are paths, all others are in the bins.
    EnergyResponse response(std::size_t source, std::size_t receiver) const;

    /// The pressures of all images, or of those that are not paths of response(), of an ambisonic
    /// order, as ImpulseResponse::channels. Each octave of an image has its own gain; equal gains
    /// add up to a pulse. The error of its delay is below -46 dB up to half the sample rate.
    std::vector<std::vector<float>> pressure(std::size_t source, std::size_t receiver,
                                             double sample_rate_hz, std::size_t samples,
                                             int ambisonic_order, bool with_paths) const;

 private:
    /// The image sources along one axis; values are energies or pressures after its walls.
    template <typename Value>
    struct AxisImage {
        double offset_m = 0;  ///< from the receiver
        int index = 0;        ///< number of reflections, negative towards the low wall
        Value value;
    };
    /// An image source as it is seen from a receiver.
    template <typename Value>
    struct Image {
        int order = 0;
        double length_m = 0;
        std::array<double, 3> offset_m{};  ///< from the receiver
        std::array<int, 3> index{};        ///< AxisImage::index
        Value value;                       ///< after all walls, distance, air and directivity

        Vec3 direction() const;  ///< to the image; shorter within 0.1 m, as SoundPath::direction
        Vec3 departure() const;  ///< from the source, world axes
    };

    /// Images with the same reflections along two axes.
    template <typename Value>
    struct Row {
        const AxisImage<Value>&x, &y;
        std::span<const AxisImage<Value>> zs;
        std::span<const double> lengths_m, spread;

        int order() const { return std::abs(x.index) + std::abs(y.index); }
        Image<Value> image(std::size_t k) const;  ///< without air and directivity
    };

    BoxImages() = default;
    template <typename Value>
    std::vector<AxisImage<Value>> along(std::size_t axis, const Vec3& source, const Vec3& receiver,
                                        bool is_pressure) const;
    template <typename Value, typename Each>
    void visit_rows(std::size_t source, std::size_t receiver, bool is_pressure,
                    const Each& each) const;
    template <typename Value, typename Each>
    void visit(std::size_t source, std::size_t receiver, bool is_pressure, const Each& each) const;
    template <typename Value>
    SoundPath path_of(const Image<Value>& image) const;
    void add_bins(std::size_t source, std::size_t receiver, EnergyResponse& response) const;
    void add_flat_bins(std::size_t source, std::size_t receiver, EnergyResponse& response) const;
    std::vector<float> flat_pressure(std::size_t source, std::size_t receiver,
                                     double sample_rate_hz, std::size_t samples) const;
    template <typename Value>
    std::vector<std::vector<float>> pressure_of(std::size_t source, std::size_t receiver,
                                                double sample_rate_hz, std::size_t samples,
                                                int ambisonic_order, bool with_paths) const;
    bool is_flat(std::size_t source) const;

    Vec3 low_{0}, high_{0};
    std::array<std::array<Bands, 2>, 3> reflected_{};  ///< [axis][low, high]
    std::vector<Source> sources_;
    std::vector<Vec3> receivers_;
    Bands attenuation_per_m_;
    float speed_m_s_ = 0;
    int path_order_ = 0;
    double length_s_ = 0;
};

}  // namespace aula
