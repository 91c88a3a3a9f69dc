#include "turgor/sim/live/session_requests.hpp"

#include <thread>

#include <gtest/gtest.h>

#include "turgor/core/timing.hpp"

namespace turgor {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

// A batch has all requests since the previous one, in order.
TEST(RequestQueue, TakesAllRequestsInOrder) {
  RequestQueue queue;
  std::deque<Request> batch;
  EXPECT_TRUE(queue.take(false, batch));
  EXPECT_TRUE(batch.empty());
  queue.push(PaceRequest{.plays = false}), queue.push(StepRequest{}), queue.push(ResetRequest{});
  EXPECT_TRUE(queue.take(true, batch));
  ASSERT_EQ(batch.size(), 3u);
  EXPECT_TRUE(std::holds_alternative<PaceRequest>(batch[0]));
  EXPECT_TRUE(std::holds_alternative<StepRequest>(batch[1]));
  EXPECT_TRUE(std::holds_alternative<ResetRequest>(batch[2]));
}

// A request wakes a thread that waits for one.
TEST(RequestQueue, RequestWakesWaitingThread) {
  RequestQueue queue;
  std::deque<Request> batch;
  std::thread thread([&] { queue.take(true, batch); });
  std::this_thread::sleep_for(milliseconds(20));
  queue.push(StepRequest{});
  thread.join();
  EXPECT_EQ(batch.size(), 1u);
}

// Requests do not shorten the wait of a single step.
TEST(RequestQueue, RequestDoesNotShortenTimedWait) {
  RequestQueue queue;
  const Timer timer;
  queue.push(StepRequest{});
  queue.wait_until(steady_clock::now() + milliseconds(30));
  EXPECT_GE(timer.seconds(), 0.029);
}

// The end of a session interrupts every wait.
TEST(RequestQueue, EndInterruptsWaits) {
  RequestQueue queue;
  const Timer timer;
  std::thread thread([&queue] {
    std::this_thread::sleep_for(milliseconds(20));
    queue.end();
  });
  queue.wait_until(steady_clock::now() + seconds(60));
  EXPECT_LT(timer.seconds(), 30);
  std::deque<Request> batch;
  EXPECT_FALSE(queue.take(true, batch));
  thread.join();
}

}  // namespace
}  // namespace turgor
