// A build in which the processes of a fluid speak by MPI.

#include <algorithm>
#include <cstdlib>

#include <mpi.h>

#include "base/timing.hpp"
#include "ranks/ranks.hpp"
#include "ranks/waiting.hpp"

namespace tern {
namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 30;  ///< of one message: MPI counts in int

Traffic said;
double with_ranks_s = 0;  ///< of the one thread that speaks with them

void count_collective(std::size_t bytes) {
  ++said.collectives;
  said.collective_bytes += static_cast<std::int64_t>(bytes);
}

/// A number of a reduction in which some are added up and of others the greatest is looked for.
struct SumOrMost {
  double value;
  double is_most;
};

void add_or_choose(void* from, void* to, int* n, MPI_Datatype*) {
  const auto* const one = static_cast<const SumOrMost*>(from);
  auto* const other = static_cast<SumOrMost*>(to);
  for (int k = 0; k < *n; ++k) {
    double& value = other[k].value;
    value = other[k].is_most == 0 ? value + one[k].value : std::max(value, one[k].value);
  }
}

bool at_work() {
  int begun = 0, ended = 0;
  MPI_Initialized(&begun);
  MPI_Finalized(&ended);
  return begun && !ended;
}

}  // namespace

Ranks Ranks::all() {
  Ranks ranks;
  if (!at_work()) return ranks;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks.count_);
  MPI_Comm_rank(MPI_COMM_WORLD, &ranks.own_);
  return ranks;
}

const Traffic& Ranks::traffic() { return said; }

void Ranks::exchange(std::span<const RankMessage> give, std::span<const RankMessage> take, Subject subject) const {
  ++(subject == Subject::particles ? said.particle_exchanges : subject == Subject::nodes ? said.node_exchanges : said.other_exchanges);
  said.messages += static_cast<std::int64_t>(give.size());
  for (const RankMessage& message : give) said.bytes += static_cast<std::int64_t>(message.size);
  const ScopedTimer timer(with_ranks_s);
  thread_local std::vector<MPI_Request> requests;
  requests.clear();
  const auto post = [&](const RankMessage& message, auto&& begin) {
    for (std::size_t first = 0; first < message.size; first += most_bytes) {
      requests.emplace_back();
      begin(static_cast<char*>(message.bytes) + first, static_cast<int>(std::min(most_bytes, message.size - first)), requests.back());
    }
  };
  for (const RankMessage& message : take)
    post(message, [&](void* to, int n, MPI_Request& request) { MPI_Irecv(to, n, MPI_BYTE, message.rank, 0, MPI_COMM_WORLD, &request); });
  for (const RankMessage& message : give)
    post(message,
         [&](void* from, int n, MPI_Request& request) { MPI_Isend(from, n, MPI_BYTE, message.rank, 0, MPI_COMM_WORLD, &request); });
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

void Ranks::combine(void* values, std::size_t n, Kind kind, Operation operation) const {
  const ScopedTimer timer(with_ranks_s);
  const MPI_Datatype type = kind == Kind::real     ? MPI_DOUBLE
                            : kind == Kind::single ? MPI_FLOAT
                            : kind == Kind::whole  ? MPI_INT64_T
                                                   : MPI_UINT8_T;
  const MPI_Op op = operation == Operation::sum ? MPI_SUM : operation == Operation::least ? MPI_MIN : MPI_MAX;
  count_collective(n * (kind == Kind::real || kind == Kind::whole ? 8 : kind == Kind::single ? 4 : 1));
  // All ranks get the same bits: a library sums each number on one rank, or in pairs, whose order does not matter.
  MPI_Allreduce(MPI_IN_PLACE, values, static_cast<int>(n), type, op, MPI_COMM_WORLD);
}

void Ranks::sum_and_most(std::span<double> sums, std::span<double> most) const {
  if (alone()) return;
  static MPI_Datatype pair = MPI_DATATYPE_NULL;
  static MPI_Op op = MPI_OP_NULL;
  if (op == MPI_OP_NULL) {
    MPI_Type_contiguous(2, MPI_DOUBLE, &pair);
    MPI_Type_commit(&pair);
    MPI_Op_create(add_or_choose, 1, &op);
  }
  thread_local std::vector<SumOrMost> values;
  values.clear();
  for (const double value : sums) values.push_back({value, 0});
  for (const double value : most) values.push_back({value, 1});
  count_collective(values.size() * sizeof(SumOrMost));
  const ScopedTimer timer(with_ranks_s);
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), pair, op, MPI_COMM_WORLD);
  std::size_t next = 0;
  for (double& value : sums) value = values[next++].value;
  for (double& value : most) value = values[next++].value;
}

void Ranks::extremes(std::span<double> low, std::span<double> high) const {
  if (alone()) return;
  thread_local std::vector<double> values;
  values.clear();
  for (const double value : low) values.push_back(-value);
  values.insert(values.end(), high.begin(), high.end());
  most(std::span(values));
  for (std::size_t c = 0; c < low.size(); ++c) low[c] = -values[c], high[c] = values[low.size() + c];
}

void Ranks::swap_sizes(std::vector<std::int64_t>& sizes) const {
  const ScopedTimer timer(with_ranks_s);
  std::vector<std::int64_t> from(sizes.size());
  count_collective(sizes.size() * sizeof(std::int64_t));
  MPI_Alltoall(sizes.data(), 1, MPI_INT64_T, from.data(), 1, MPI_INT64_T, MPI_COMM_WORLD);
  sizes.swap(from);
}

void Ranks::tell(void* bytes, std::size_t size, int from) const {
  if (alone()) return;
  count_collective(size);
  const ScopedTimer timer(with_ranks_s);
  for (std::size_t first = 0; first < size; first += most_bytes)
    MPI_Bcast(static_cast<char*>(bytes) + first, static_cast<int>(std::min(most_bytes, size - first)), MPI_BYTE, from, MPI_COMM_WORLD);
}

std::string Ranks::first_word(const std::string& own) const {
  if (alone()) return own;
  int speaker = own.empty() ? count_ : own_;
  count_collective(sizeof speaker);
  {
    const ScopedTimer timer(with_ranks_s);
    MPI_Allreduce(MPI_IN_PLACE, &speaker, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  }
  if (speaker == count_) return {};
  std::string word = own;
  std::uint64_t size = word.size();
  tell(&size, sizeof size, speaker);
  word.resize(size);
  tell(word.data(), size, speaker);
  return word;
}

RanksAtWork::RanksAtWork() {
  int given = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &given);
}
RanksAtWork::~RanksAtWork() { MPI_Finalize(); }
bool ranks_were_started() {
  // Of Open MPI and of MPICH. Without them MPI is not asked to begin: it would start a process of its own.
  return std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr || std::getenv("PMI_SIZE") != nullptr;
}
void abandon_ranks(int exit_code) {
  if (at_work()) MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::_Exit(exit_code);
}
double seconds_with_ranks() { return with_ranks_s; }

}  // namespace tern
