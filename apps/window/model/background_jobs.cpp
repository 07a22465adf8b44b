#include "apps/window/model/background_jobs.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <iterator>
#include <utility>

namespace aula {

void BackgroundJobs::start(std::string name, std::function<LastPart()> job) {
    jobs_.push_back({std::move(name), std::async(std::launch::async, std::move(job))});
}

bool BackgroundJobs::runs(std::string_view name) const {
    return std::any_of(jobs_.begin(), jobs_.end(),
                       [&](const Job& job) { return job.name == name; });
}

std::string BackgroundJobs::newest() const { return jobs_.empty() ? "" : jobs_.back().name; }

void BackgroundJobs::finish(const std::function<void(const std::string&)>& report) {
    const auto done = std::stable_partition(jobs_.begin(), jobs_.end(), [](const Job& job) {
        return job.last_part.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
    });
    // A last part may start another job.
    std::vector<Job> completed(std::make_move_iterator(done), std::make_move_iterator(jobs_.end()));
    jobs_.erase(done, jobs_.end());
    for (Job& job : completed) {
        try {
            job.last_part.get()();
        } catch (const std::exception& thrown) {
            report(thrown.what());
        }
    }
}

}  // namespace aula
