#include "apps/documents/document_measurement.h"
#include "apps/window/model/model.h"
#include "apps/window/model/saved_files.h"
#include "aula/audio/realtime.h"

// The map of the model.

namespace aula {

namespace {

constexpr const char* kFindingModes = "finding modes";

}  // namespace

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

void Model::start_standing_waves(double height_m) {
    if (finds_standing_waves() || !may_change()) return;
    jobs_.start(kFindingModes,
                [this, height_m, version = geometry_version(), bounds = bounds(),
                 played = played_scene(scene(), controls_,
                                       setting().simulation)]() -> BackgroundJobs::LastPart {
                    lower_priority(kPropagationNice + 5);
                    auto waves = std::make_shared<const StandingWaves>(played, bounds, height_m);
                    return [this, waves, version] {
                        if (version != geometry_version()) return;
                        waves_ = waves;
                        waves_version_ = version;
                        for (const std::string& line : waves->warnings()) log_.say(line, true);
                    };
                });
}

bool Model::finds_standing_waves() const { return jobs_.runs(kFindingModes); }

/// Drops a map of another geometry or other sources, and the modes of another geometry.
void Model::drop_old_map() {
    if (waves_version_ != geometry_version()) waves_.reset();
    if (!map_ || (map_version_ == geometry_version() &&
                  map_->measurement.sources.size() == scene().sources.size()))
        return;
    map_.reset();
}

}  // namespace aula
