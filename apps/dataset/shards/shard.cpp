#include "apps/dataset/shards/shard.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "apps/dataset/base/tar.h"
#include "apps/dataset/plan/plan_reader.h"
#include "apps/dataset/shards/item.h"
#include "apps/output/output_file.h"
#include "aula/exception.h"

namespace aula {

namespace {

/// The shard file while it is written.
class ShardWriter {
 public:
    explicit ShardWriter(const std::filesystem::path& file) : out_(place_of(file)) {}

    void write(const Item& item) {
        const std::string name = Plan::item_name(item.index);
        write(name + ".json", item.json);
        if (!item.wav.empty()) write(name + ".wav", item.wav);
        ++(item.wav.empty() ? contents_.errors : contents_.responses);
    }

    ShardContents commit() {
        out_.write(tar_end());
        out_.commit();
        return contents_;
    }

    std::uint64_t items() const { return contents_.responses + contents_.errors; }

 private:
    /// OutputFile writes into a pipe, which would block.
    static std::filesystem::path place_of(const std::filesystem::path& file) {
        std::error_code error;
        const auto status = std::filesystem::status(file, error);
        if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
            throw InputError(file.string(), "", "is not a regular file; expected a shard, or none");
        return file;
    }
    void write(const std::string& name, const std::string& content) {
        out_.write(tar_header(name, content.size()));
        out_.write(content);
        out_.write(tar_padding(content.size()));
    }

    OutputFile out_;
    ShardContents contents_;
};

/// Computes scenes on several threads and returns their items in the order of the scenes. At most
/// two scenes per thread are in memory.
class SceneQueue {
 public:
    SceneQueue(const Plan& plan, const ShardRange& range, int threads,
               std::function<bool()> continues)
        : plan_(plan),
          reader_(plan, range),
          files_(plan.manifest_folder),
          continues_(std::move(continues)),
          ahead_(2 * static_cast<std::uint64_t>(threads)),
          working_(static_cast<std::size_t>(threads)) {
        try {
            for (int t = 0; t < threads; ++t) threads_.emplace_back([this] { work(); });
        } catch (...) {
            stop();
            throw;
        }
    }

    ~SceneQueue() { stop(); }
    SceneQueue(const SceneQueue&) = delete;
    SceneQueue& operator=(const SceneQueue&) = delete;

    /// The items of the next scene; empty if there is none or `continues` returned false.
    std::optional<std::vector<Item>> next() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return done_.contains(taken_) || error_ || working_ == 0; });
        if (error_) std::rethrow_exception(error_);
        auto node = done_.extract(taken_);
        if (node.empty()) return std::nullopt;
        ++taken_;
        changed_.notify_all();
        return std::move(node.mapped());
    }

 private:
    void stop() {
        {
            const std::lock_guard lock(mutex_);
            stopped_ = true;
        }
        changed_.notify_all();
        for (std::thread& thread : threads_) thread.join();
    }

    void work() {
        try {
            while (compute_next()) {
            }
        } catch (...) {
            const std::lock_guard lock(mutex_);
            if (!error_) error_ = std::current_exception();
        }
        const std::lock_guard lock(mutex_);
        --working_;
        changed_.notify_all();
    }

    bool compute_next() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return stopped_ || error_ || begun_ < taken_ + ahead_; });
        if (stopped_ || error_) return false;
        const std::optional<PlannedScene> scene = reader_.next();
        if (!scene) return false;
        const std::uint64_t number = begun_++;
        lock.unlock();
        auto items =
            compute_items(plan_, *scene, files_, [&] { return !stopped_ && continues_(); });
        lock.lock();
        if (!items) return false;
        done_.emplace(number, std::move(*items));
        changed_.notify_all();
        return true;
    }

    const Plan& plan_;
    PlanReader reader_;
    SceneFiles files_;
    std::function<bool()> continues_;
    const std::uint64_t ahead_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::map<std::uint64_t, std::vector<Item>> done_;
    std::uint64_t begun_ = 0;  ///< scenes, in the order of the plan
    std::uint64_t taken_ = 0;
    std::atomic<bool> stopped_ = false;
    std::exception_ptr error_;
    std::size_t working_;  ///< threads that have not ended
    std::vector<std::thread> threads_;
};

}  // namespace

std::optional<ShardContents> compute_shard(const Plan& plan, std::size_t shard, int threads,
                                           const std::function<bool()>& continues,
                                           const std::function<void(std::uint64_t)>& report) {
    const ShardRange& range = plan.shards.at(shard);
    ShardWriter writer(plan.shard_file(shard));
    SceneQueue scenes(plan, range, threads, continues);
    while (const auto items = scenes.next()) {
        for (const Item& item : *items) writer.write(item);
        report(writer.items());
    }
    if (writer.items() < range.end_item - range.first_item) return std::nullopt;
    return writer.commit();
}

}  // namespace aula
