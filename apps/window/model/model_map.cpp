#include "apps/documents/document_measurement.h"
#include "apps/window/model/model.h"
#include "apps/window/model/saved_files.h"
#include "aula/audio/realtime.h"

// The map of the model.

namespace aula {

void Model::start_map(double height_m, double spacing_m) {
    if (map_job_.runs() || !may_change()) return;
    auto progress = std::make_shared<MapProgress>();
    map_job_.progress = progress;
    jobs_.start("measuring a map",
                [this, progress, height_m, spacing_m, setting = wanted_setting(),
                 positions = source_positions(), version = geometry_version(),
                 played = played_scene(scene(), controls_,
                                       setting().simulation)]() -> BackgroundJobs::LastPart {
                    // Threads that the measurement starts have the same priority.
                    lower_priority(kPropagationNice + 5);
                    const MapProgress::End end{*progress};
                    auto mapped = std::make_shared<MappedRoom>();
                    mapped->grid = receiver_grid(played, RayScene(played), height_m, spacing_m);
                    auto measured = measure_map(played, mapped->grid, {}, {}, [&](double done) {
                        progress->done = done;
                        return !progress->cancelled;
                    });
                    if (!measured) return [] {};
                    mapped->measurement = std::move(*measured);
                    return [this, mapped, progress, setting, positions, version] {
                        if (progress->cancelled || version != geometry_version()) return;
                        map_ = mapped;
                        map_setting_ = setting;
                        map_positions_ = positions;
                        map_version_ = version;
                    };
                });
}

std::optional<double> Model::map_progress() const {
    if (!map_job_.runs()) return std::nullopt;
    return map_job_.progress->done.load();
}

bool Model::map_is_current() const {
    return map_setting_ == wanted_setting() && map_positions_ == source_positions();
}

/// Drops a map of another geometry or other sources.
void Model::drop_old_map() {
    if (!map_ || (map_version_ == geometry_version() &&
                  map_->measurement.sources.size() == scene().sources.size()))
        return;
    map_.reset();
}

}  // namespace aula
