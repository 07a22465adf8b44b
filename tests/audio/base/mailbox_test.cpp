#include "audio/base/mailbox.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <deque>
#include <memory>
#include <set>
#include <thread>

using namespace aula;

namespace {

/// Counts its instances, which reveals leaks and double frees.
struct Letter {
    explicit Letter(int n) : number(n), copy(n) { ++alive; }
    ~Letter() { --alive; }
    Letter(const Letter&) = delete;
    Letter& operator=(const Letter&) = delete;

    int number;
    int copy;  ///< differs from `number` in a partly written letter
    static inline std::atomic<int> alive{0};
};

}  // namespace

TEST_CASE("The reader of a mailbox gets the newest value once") {
    Mailbox<Letter> mailbox(1);
    CHECK(mailbox.take() == nullptr);
    mailbox.publish(std::make_unique<Letter>(1));
    mailbox.publish(std::make_unique<Letter>(2));
    Letter* const letter = mailbox.take();
    REQUIRE(letter != nullptr);
    CHECK(letter->number == 2);
    CHECK(mailbox.take() == nullptr);
    mailbox.give_back(letter);
}

TEST_CASE("Replaced and returned values go back to the writer of a mailbox") {
    Mailbox<Letter> mailbox(1);
    CHECK(mailbox.reclaim() == nullptr);
    mailbox.publish(std::make_unique<Letter>(1));
    mailbox.publish(std::make_unique<Letter>(2));
    mailbox.give_back(mailbox.take());
    std::set<int> returned;
    while (const std::unique_ptr<Letter> letter = mailbox.reclaim())
        returned.insert(letter->number);
    CHECK(returned == std::set<int>{1, 2});
}

TEST_CASE("A mailbox frees its values and those that the writer never reclaims") {
    REQUIRE(Letter::alive == 0);
    {
        Mailbox<Letter> mailbox(1);
        for (int i = 0; i < 100; ++i) mailbox.publish(std::make_unique<Letter>(i));
        CHECK(Letter::alive <= 2);
        for (int i = 0; i < 100; ++i) {
            mailbox.publish(std::make_unique<Letter>(i));
            mailbox.give_back(mailbox.take());
        }
        CHECK(Letter::alive <= static_cast<int>(mailbox.capacity()));
    }
    CHECK(Letter::alive == 0);
}

TEST_CASE("Values that nobody takes do not change how many a mailbox holds later") {
    REQUIRE(Letter::alive == 0);
    {
        Mailbox<Letter> mailbox(1);
        for (int i = 0; i < 3; ++i) mailbox.publish(std::make_unique<Letter>(i));
        Letter* held = mailbox.take();
        for (int i = 3; i < 5; ++i) mailbox.publish(std::make_unique<Letter>(i));
        for (int i = 5; i < 20; ++i) {
            mailbox.give_back(held);
            mailbox.publish(std::make_unique<Letter>(i));
            held = mailbox.take();
            REQUIRE(held != nullptr);
            REQUIRE(held->number == i);
            REQUIRE(Letter::alive <= static_cast<int>(mailbox.capacity()));
        }
        mailbox.give_back(held);
    }
    CHECK(Letter::alive == 0);
}

TEST_CASE("A reader that holds the largest number of values does not block the writer") {
    REQUIRE(Letter::alive == 0);
    const std::size_t max = GENERATE(std::size_t{1}, std::size_t{2}, std::size_t{8});
    {
        Mailbox<Letter> mailbox(max);
        std::deque<Letter*> held;
        int last = 0;
        for (int i = 1; i <= 1000; ++i) {
            mailbox.publish(std::make_unique<Letter>(i));
            // The writer is sometimes faster.
            if (i % 7 == 0) continue;
            Letter* const letter = mailbox.take();
            REQUIRE(letter != nullptr);
            CHECK(letter->number == i);
            last = i;
            held.push_back(letter);
            if (held.size() < max) continue;
            // Sometimes all values are returned, which fills the ring of used values.
            do {
                mailbox.give_back(held.front());
                held.pop_front();
            } while (i % 5 == 0 && !held.empty());
            CHECK(Letter::alive <= static_cast<int>(mailbox.capacity()));
        }
        CHECK(last == 1000);
        for (Letter* const letter : held) mailbox.give_back(letter);
    }
    CHECK(Letter::alive == 0);
}

TEST_CASE("Between two threads values arrive complete and in order, and the last one arrives") {
    REQUIRE(Letter::alive == 0);
    constexpr int kLetters = 200000;
    {
        // One is taken before the previous one is given back.
        Mailbox<Letter> mailbox(2);
        int backwards = 0;
        int torn = 0;
        int last = 0;
        // The reader holds two at a time, like a renderer in a crossfade.
        std::thread reader([&] {
            Letter* held = nullptr;
            while (last < kLetters) {
                Letter* const letter = mailbox.take();
                if (letter == nullptr) continue;
                if (letter->number <= last) ++backwards;
                if (letter->number != letter->copy) ++torn;
                last = letter->number;
                if (held != nullptr) mailbox.give_back(held);
                held = letter;
            }
            if (held != nullptr) mailbox.give_back(held);
        });
        for (int i = 1; i <= kLetters; ++i) {
            std::unique_ptr<Letter> letter = mailbox.reclaim();
            if (letter) {
                letter->number = i;
                letter->copy = i;
            } else {
                letter = std::make_unique<Letter>(i);
            }
            mailbox.publish(std::move(letter));
        }
        reader.join();
        CHECK(last == kLetters);
        CHECK(backwards == 0);
        CHECK(torn == 0);
        // At most two values were held by the reader, one published and one being filled.
        CHECK(Letter::alive <= 4);
    }
    CHECK(Letter::alive == 0);
}
