#include "apps/window/model/background_jobs.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/wait.h"

using namespace aula;
using namespace aula::test;

namespace {

/// Calls finish() until a condition holds; false after a long time.
template <typename Condition>
bool finishes(BackgroundJobs& jobs, std::vector<std::string>& errors, const Condition& holds) {
    return eventually([&] {
        jobs.finish([&](const std::string& error) { errors.push_back(error); });
        return holds();
    });
}

}  // namespace

TEST_CASE("A job runs on a thread and its last part on the thread that calls finish()") {
    BackgroundJobs jobs;
    std::thread::id job_thread;
    std::thread::id last_thread;
    std::promise<void> may_end;
    jobs.start("reading", [&, end = may_end.get_future().share()]() -> BackgroundJobs::LastPart {
        end.wait();
        job_thread = std::this_thread::get_id();
        return [&] { last_thread = std::this_thread::get_id(); };
    });
    CHECK(jobs.runs("reading"));
    CHECK_FALSE(jobs.runs("writing"));
    CHECK(jobs.newest() == "reading");
    jobs.finish([](const std::string&) {});
    CHECK(jobs.runs("reading"));

    may_end.set_value();
    std::vector<std::string> errors;
    REQUIRE(finishes(jobs, errors, [&] { return last_thread != std::thread::id(); }));
    CHECK(last_thread == std::this_thread::get_id());
    CHECK(job_thread != last_thread);
    CHECK_FALSE(jobs.runs("reading"));
    CHECK(jobs.newest().empty());
    CHECK(errors.empty());
}

TEST_CASE("Exceptions of a job and of its last part are reported, and other jobs complete") {
    BackgroundJobs jobs;
    bool completed = false;
    jobs.start("a", []() -> BackgroundJobs::LastPart { throw std::runtime_error("of the job"); });
    jobs.start("b", []() -> BackgroundJobs::LastPart {
        return [] { throw std::runtime_error("of the last part"); };
    });
    jobs.start("c", [&]() -> BackgroundJobs::LastPart { return [&] { completed = true; }; });
    std::vector<std::string> errors;
    REQUIRE(finishes(jobs, errors, [&] { return errors.size() == 2 && completed; }));
    std::sort(errors.begin(), errors.end());
    CHECK(errors == std::vector<std::string>{"of the job", "of the last part"});
}

TEST_CASE("A last part may start another job") {
    BackgroundJobs jobs;
    bool completed = false;
    jobs.start("first", [&]() -> BackgroundJobs::LastPart {
        return [&] {
            jobs.start("second",
                       [&]() -> BackgroundJobs::LastPart { return [&] { completed = true; }; });
        };
    });
    std::vector<std::string> errors;
    CHECK(finishes(jobs, errors, [&] { return completed; }));
}

TEST_CASE("After a job has completed, newest() names the one started last of those that run") {
    BackgroundJobs jobs;
    std::promise<void> may_end;
    const auto end = may_end.get_future().share();
    const auto waiting = [end]() -> BackgroundJobs::LastPart {
        end.wait();
        return [] {};
    };
    jobs.start("short", []() -> BackgroundJobs::LastPart { return [] {}; });
    jobs.start("one", waiting);
    jobs.start("two", waiting);
    std::vector<std::string> errors;
    REQUIRE(finishes(jobs, errors, [&] { return !jobs.runs("short"); }));
    CHECK(jobs.newest() == "two");
    may_end.set_value();
}

TEST_CASE("The destructor waits for the jobs and drops their last parts") {
    std::atomic<bool> ended = false;
    bool last_part = false;
    {
        BackgroundJobs jobs;
        jobs.start("slow", [&]() -> BackgroundJobs::LastPart {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            ended = true;
            return [&] { last_part = true; };
        });
    }
    CHECK(ended);
    CHECK_FALSE(last_part);
}
