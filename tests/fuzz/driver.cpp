// Runs a fuzz target without libFuzzer: every file of a corpus, then so many seeded random mutations of its
// files. Usage: fuzz_<name> CORPUS [MUTATIONS [SEED [SECONDS]]]
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace {

void run(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

std::vector<std::string> read_corpus(const char* folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return corpus;
}

/// One to six changes, most of them near the start, where headers are.
std::string mutated(std::string input, const std::vector<std::string>& corpus, std::mt19937_64& random) {
  const auto below = [&](std::size_t count) {
    return std::size_t(random() % std::max<std::size_t>(count, 1));
  };
  constexpr unsigned char kEdges[] = {0, 1, 0x7f, 0x80, 0xff, ' ', '-', '9', '\n', 'e'};
  for (std::size_t change = 0, changes = 1 + below(6); change < changes; change++) {
    const std::size_t at = below(below(2) ? input.size() : std::min<std::size_t>(input.size(), 600));
    switch (below(7)) {
      case 0:
        if (!input.empty()) input[at] = char(random());
        break;
      case 1:
        if (!input.empty()) input[at] = char(kEdges[below(sizeof kEdges)]);
        break;
      case 2:
        if (!input.empty()) input[at] = char(input[at] ^ (1 << below(8)));
        break;
      case 3:
        input.erase(at, 1 + below(16));
        break;
      case 4:
        input.insert(at, 1 + below(8), char(kEdges[below(sizeof kEdges)]));
        break;
      case 5:
        input.resize(at);
        break;
      default: {  // a piece of another input
        const std::string& other = corpus[below(corpus.size())];
        const std::size_t from = below(other.size());
        input.replace(at, below(32), other.substr(from, 1 + below(64)));
      }
    }
  }
  return input;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s CORPUS [MUTATIONS [SEED [SECONDS]]]\n", argv[0]), 1;
  const std::vector<std::string> corpus = read_corpus(argv[1]);
  if (corpus.empty()) return std::fprintf(stderr, "%s: no corpus\n", argv[1]), 1;
  const long mutations = argc > 2 ? std::atol(argv[2]) : 2000, seed = argc > 3 ? std::atol(argv[3]) : 1;
  const double seconds = argc > 4 ? std::atof(argv[4]) : 1e9;
  const auto start = std::chrono::steady_clock::now();
  for (const std::string& input : corpus) run(input);
  long done = 0;
  for (; done < mutations; done++) {
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) break;
    std::mt19937_64 random(std::uint64_t(seed) * 1000003 +
                           std::uint64_t(done));  // any mutation can be repeated alone
    const std::string input = mutated(corpus[std::size_t(random() % corpus.size())], corpus, random);
    if (const char* keep = std::getenv("TURGOR_FUZZ_LAST")) std::ofstream(keep, std::ios::binary) << input;
    run(input);
  }
  std::printf("%zu inputs and %ld mutations, no crash\n", corpus.size(), done);
  return 0;
}
