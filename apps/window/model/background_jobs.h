#pragma once

#include <functional>
#include <future>
#include <string>
#include <string_view>
#include <vector>

namespace aula {

/// Named jobs, each on a thread of the background. The last part of a job runs in finish(). The
/// destructor waits for all jobs and discards their last parts. [one thread]
class BackgroundJobs {
 public:
    /// The last part of a job, such as showing its result.
    using LastPart = std::function<void()>;

    void start(std::string name, std::function<LastPart()> job);

    bool runs(std::string_view name) const;

    /// Name of the running job that was started last; empty: none.
    std::string newest() const;

    /// Runs the last parts of the completed jobs in the order of their start. `report` receives the
    /// text of exceptions of a job or of its last part.
    void finish(const std::function<void(const std::string& error)>& report);

 private:
    struct Job {
        std::string name;
        std::future<LastPart> last_part;
    };
    std::vector<Job> jobs_;
};

}  // namespace aula
