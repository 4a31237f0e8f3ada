/* SPDX-License-Identifier: BSD-3-Clause
 *
 * What scalable_isosurface.h promises, in C99. The first argument is a folder for files.
 */
#define _POSIX_C_SOURCE 200809L
#include <signal.h> /* whose macros begin with si_, too */

#include <scalable_isosurface.h>

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define CHECK(condition)                                                                          \
  ((condition) ? (void)0                                                                          \
               : (fprintf(stderr, "%s:%d: %s; %s\n", __FILE__, __LINE__, #condition, si_error()), \
                   exit(EXIT_FAILURE)))
#define OK(call) CHECK((call) == SI_OK)

enum
{
  NX = 40,
  NY = 37,
  NZ = 70,
  RANKS = 3
};
static char path[4096], other[4096], eix[4096], raw[4096], first[4096], stopped[4096];

static int16_t sample(size_t step, int64_t x, int64_t y, int64_t z)
{
  const double place = sin(0.3 * (double)x) + cos(0.2 * (double)y) * sin(0.25 * (double)z);
  return (int16_t)(1000 * place + 10 * (double)step);
}

/* Two arrays: int16, and two components of float32. */
static int read_box(const si_reading* reading)
{
  size_t number = 0;
  CHECK(*(int*)reading->context == 4711);
  for (int64_t z = reading->low[2]; z < reading->high[2]; ++z)
    for (int64_t y = reading->low[1]; y < reading->high[1]; ++y)
      for (int64_t x = reading->low[0]; x < reading->high[0]; ++x, ++number)
      {
        if (reading->array == 0)
        {
          ((int16_t*)reading->samples)[number] = sample(reading->step, x, y, z);
        }
        else
        {
          ((float*)reading->samples)[2 * number] = (float)x;
          ((float*)reading->samples)[2 * number + 1] = (float)z;
        }
      }
  CHECK(reading->bytes == number * (reading->array == 0 ? 2 : 8));
  return 1;
}

static int fail_to_read(const si_reading* reading)
{
  (void)reading;
  return 0;
}

static si_volume* open_volume(const char* name)
{
  si_volume* volume = NULL;
  OK(si_volume_open(name, NULL, NULL, &volume));
  return volume;
}

static void write_and_describe(void)
{
  const si_array arrays[] = { { "ct", SI_INT16, 1, "HU" }, { "place", SI_FLOAT32, 2, NULL } };
  const double times[] = { 0.5, 2 };
  int context = 4711;
  si_grid grid = { sizeof(grid), { NX, NY, NZ }, { 0.5, 1, 2 }, { 10, 20, 30 },
    { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { NULL }, "mm", { 0 }, { 0 }, { 0 } };
  si_settings settings = { .size = sizeof(settings) };
  settings.block_size = 16;
  OK(si_write_volume(path, &grid, 2, arrays, 2, times, read_box, &context, &settings, NULL));
  CHECK(si_write_volume(other, &grid, 2, arrays, 1, NULL, fail_to_read, NULL, NULL, NULL) ==
    SI_IO_ERROR);
  CHECK(access(other, F_OK) != 0);
  grid.length_unit = "parsec";
  CHECK(si_write_volume(other, &grid, 2, arrays, 1, NULL, read_box, &context, NULL, NULL) ==
    SI_INVALID_ARGUMENT);
  CHECK(strstr(si_error(), "parsec"));

  si_volume* volume = open_volume(path);
  const si_volume_info* info = si_volume_describe(volume);
  CHECK(info->array_count == 2 && strcmp(info->arrays[0].name, "ct") == 0 &&
    info->arrays[1].components == 2);
  CHECK(strcmp(info->arrays[0].unit, "HU") == 0 && info->step_count == 2 && info->times[0] == 0.5);
  CHECK(info->level_count > 2 && strcmp(info->left_out, "") == 0 &&
    !si_volume_grid(volume, info->level_count));
  const si_grid* level = si_volume_grid(volume, 1);
  CHECK(level->dimensions[0] == NX / 2 && level->spacing[2] == 4 && level->origin[1] == 20);
  CHECK(strcmp(level->length_unit, "mm") == 0 && !level->lines[0] && level->direction[4] == 1);
  si_volume_close(volume);

  const double spacing[] = { 1, 1, 1 };
  si_opening opening = { .size = sizeof(opening) };
  opening.spacing = spacing;
  opening.length_unit = "parsec";
  CHECK(si_volume_open(path, &opening, NULL, &volume) == SI_INVALID_ARGUMENT);
  opening.length_unit = "um";
  OK(si_volume_open(path, &opening, NULL, &volume));
  CHECK(si_volume_grid(volume, 0)->spacing[2] == 1 &&
    strcmp(si_volume_grid(volume, 0)->length_unit, "um") == 0);
  OK(si_volume_write(volume, other, NULL, NULL, NULL, NULL));
  si_volume_close(volume);
  volume = open_volume(other);
  CHECK(si_volume_describe(volume)->step_count == 2 && si_volume_describe(volume)->times[1] == 2);
  CHECK(si_volume_grid(volume, 0)->spacing[2] == 1);
  si_volume_close(volume);
}

static void read_samples(void)
{
  si_volume* volume = open_volume(path);
  si_box box = { .size = sizeof(box) };
  const int64_t low[] = { 3, 5, 7 }, high[] = { 20, 6, 64 };
  memcpy(box.low, low, sizeof(low));
  memcpy(box.high, high, sizeof(high));
  box.stride[0] = 2;
  box.step = 1;
  int16_t samples[9 * 57];
  OK(si_volume_read(volume, &box, samples, sizeof(samples), NULL));
  for (int z = 0; z < 57; ++z)
    for (int x = 0; x < 9; ++x)
      CHECK(samples[9 * z + x] == sample(1, 3 + 2 * x, 5, 7 + z));
  CHECK(si_volume_read(volume, &box, samples, sizeof(samples) - 1, NULL) == SI_INVALID_ARGUMENT);
  box.high[0] = NX + 1;
  CHECK(si_volume_read(volume, &box, samples, sizeof(samples), NULL) == SI_INVALID_ARGUMENT);

  double range[2] = { 0, 0 };
  int16_t least = 0, most = 0;
  for (int z = 0; z < NZ; ++z)
    for (int y = 0; y < NY; ++y)
      for (int x = 0; x < NX; ++x)
      {
        const int16_t one = sample(0, x, y, z);
        least = one < least ? one : least;
        most = one > most ? one : most;
      }
  OK(si_volume_range(volume, NULL, NULL, range));
  CHECK(range[0] == least && range[1] == most);

  const si_scalar place = { 1, 0, 0, 0 };
  const double points[] = { 10.25, 20, 31, -1, 20, 30 };
  float values[] = { 7, 7, 7, 7 };
  uint8_t inside[2];
  OK(si_volume_probe(volume, &place, 0, 2, points, values, inside, NULL));
  CHECK(
    values[0] == 0.5f && values[1] == 0.5f && values[2] == 7 && inside[0] == 1 && inside[1] == 0);

  const double origin[] = { 11, 21, 40 }, along[] = { 0, 0, 1 }, beside[] = { 0, 0, 0 };
  si_slice* slice = NULL;
  OK(si_volume_slice(volume, NULL, origin, along, 0, NULL, &slice));
  CHECK(slice->grid->dimensions[0] == NX && slice->grid->dimensions[2] == 1 && slice->level == 0);
  CHECK(((int16_t*)slice->values)[NX * 3 + 2] == sample(0, 2, 3, 5) && slice->inside[0] == 1);
  si_slice_free(slice);
  OK(si_volume_slice(volume, NULL, beside, along, 0, NULL, &slice));
  CHECK(slice == NULL);
  CHECK(si_volume_slice(volume, NULL, origin, beside, 0, NULL, &slice) == SI_INVALID_ARGUMENT);
  si_volume_close(volume);
}

static const double isovalue = 100.5;
static si_surface_request make_request(void)
{
  si_surface_request request = { .size = sizeof(request) };
  request.isovalue_count = 1;
  request.isovalues = &isovalue;
  return request;
}

/* An image in memory, in two pieces that share a layer. */
static void contour_images(void)
{
  enum
  {
    HALF = 30
  };
  static int16_t samples[NX * NY * NZ];
  static uint8_t hidden[(NX - 1) * (NY - 1) * HALF];
  si_volume* volume = open_volume(path);
  const si_grid* whole = si_volume_grid(volume, 0);
  si_box box = { .size = sizeof(box), .high = { NX, NY, NZ } };
  OK(si_volume_read(volume, &box, samples, sizeof(samples), NULL));
  si_surface_request request = make_request();
  request.normals = 1;
  si_surface* surface = NULL;
  OK(si_volume_extract(volume, &request, NULL, &surface));
  const size_t triangles = surface->triangle_count;
  si_surface_free(surface);

  const si_array array = { "ct", SI_INT16, 1, "" };
  const void* memory[2] = { samples, samples + NX * NY * HALF };
  si_grid grids[2] = { *whole, *whole };
  si_piece pieces[2] = { { .size = sizeof(si_piece) }, { .size = sizeof(si_piece) } };
  const si_piece* given[2] = { &pieces[0], &pieces[1] };
  grids[0].dimensions[2] = HALF + 1;
  grids[1].dimensions[2] = NZ - HALF;
  grids[1].first[2] = HALF;
  for (int piece = 0; piece < 2; ++piece)
  {
    pieces[piece].grid = &grids[piece];
    pieces[piece].array_count = 1;
    pieces[piece].arrays = &array;
    pieces[piece].samples = &memory[piece];
  }
  si_images* images = NULL;
  OK(si_images_create(&images));
  for (int turn = 0; turn < 2; ++turn)
  {
    OK(si_images_extract(images, 2, given, &request, NULL, &surface));
    CHECK(surface->triangle_count == triangles && surface->normals && surface->block_count == 0);
    si_surface_free(surface);
  }
  memset(hidden, 1, sizeof(hidden));
  pieces[0].hidden_cells = hidden;
  OK(si_images_extract(images, 2, given, &request, NULL, &surface));
  CHECK(surface->triangle_count > 0 && surface->triangle_count < triangles);
  si_surface_free(surface);
  OK(si_images_extract(images, 0, NULL, &request, NULL, &surface));
  CHECK(surface->triangle_count == 0);
  si_surface_free(surface);
  request.scalar.array = 1;
  CHECK(si_images_extract(images, 2, given, &request, NULL, &surface) == SI_INVALID_ARGUMENT &&
    strstr(si_error(), "no such array"));
  si_images_free(images);
  si_images_free(NULL);
  si_volume_close(volume);
}

static void extract(void)
{
  static const size_t attribute = 1;
  si_volume* volume = open_volume(path);
  si_surface_request request = make_request();
  si_surface* surface = NULL;
  request.normals = 1;
  request.attributes = &attribute;
  request.attribute_count = 1;
  OK(si_volume_extract(volume, &request, NULL, &surface));
  CHECK(surface->triangle_count > 1000 && surface->point_type == SI_FLOAT32 &&
    surface->part_count == 1);
  CHECK(surface->first_triangles[1] == (int64_t)surface->triangle_count &&
    surface->isovalues[0] == isovalue);
  const float* points = surface->points;
  const si_values* values = surface->attributes;
  for (size_t point = 0; point < surface->point_count; ++point)
  {
    const float* tuple = (const float*)values->values + 2 * point;
    CHECK(fabsf(tuple[0] - (points[3 * point] - 10) * 2) < 1e-3f &&
      fabsf(tuple[1] - (points[3 * point + 2] - 30) / 2) < 1e-3f);
    const float* normal = surface->normals + 3 * point;
    CHECK(fabsf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2] - 1) < 1e-3f);
  }
  const size_t triangles = surface->triangle_count;
  char saved[4200];
  snprintf(saved, sizeof(saved), "%s.stl", eix);
  OK(si_surface_save(surface, saved, "ct", "mm", NULL));
  struct stat file_state;
  CHECK(stat(saved, &file_state) == 0 && (size_t)file_state.st_size == 84 + 50 * triangles);
  CHECK(si_surface_save(surface, eix, NULL, NULL, NULL) == SI_INVALID_ARGUMENT &&
    strstr(si_error(), ".glb"));
  ((float*)surface->points)[0] = NAN;
  CHECK(si_surface_save(surface, saved, NULL, NULL, NULL) == SI_INVALID_ARGUMENT);
  si_surface_free(surface);

  double estimated = 0;
  OK(si_volume_estimate(volume, &request, NULL, &estimated));
  CHECK(fabs(estimated - (double)triangles) < 0.1 * (double)triangles);
  si_spectrum* spectrum = NULL;
  OK(si_volume_spectrum(volume, NULL, NULL, &spectrum));
  CHECK(spectrum->count > 100 && spectrum->triangles[spectrum->count / 2] > 0 && spectrum->area);
  si_spectrum_free(spectrum);
  si_boxes* boxes = NULL;
  OK(si_volume_find_blocks(volume, &request, NULL, &boxes));
  CHECK(boxes->count > 1 && boxes->boxes[1] == 17);
  si_boxes_free(boxes);

  request.maximum_triangles = triangles / 2;
  request.closed = 1;
  request.maximum_islands = 1;
  OK(si_volume_extract(volume, &request, NULL, &surface));
  CHECK(surface->level > 0 && surface->triangle_count < triangles && surface->triangle_count > 0);
  si_surface_free(surface);
  request = make_request();
  request.isovalue_count = 0;
  CHECK(si_volume_extract(volume, &request, NULL, &surface) == SI_INVALID_ARGUMENT);
  request = make_request();
  request.points = SI_INT16;
  CHECK(si_volume_extract(volume, &request, NULL, &surface) == SI_INVALID_ARGUMENT);
  request = make_request();
  request.scalar.array = 2;
  CHECK(si_volume_extract(volume, &request, NULL, &surface) == SI_INVALID_ARGUMENT &&
    strstr(si_error(), path));

  request = make_request();
  si_coding coding = { .size = sizeof(coding) };
  coding.preview_level = 1;
  OK(si_volume_write_surface(volume, &request, eix, &coding, NULL));
  CHECK(si_volume_write_surface(volume, &request, path, &coding, NULL) == SI_INVALID_ARGUMENT);
  si_surface_file* file = NULL;
  OK(si_surface_file_open(eix, NULL, &file));
  const si_surface_file_info* info = si_surface_file_describe(file);
  CHECK(
    info->isovalue_count == 1 && info->isovalues[0] == isovalue && strcmp(info->array, "ct") == 0);
  CHECK(info->has_preview && strcmp(info->length_unit, "mm") == 0 && info->time == 0.5);
  OK(si_surface_file_read(file, 0, NULL, 0, 1, NULL, &surface));
  CHECK(surface->triangle_count == triangles && surface->normals);
  si_surface_free(surface);
  static const size_t second = 1;
  CHECK(si_surface_file_read(file, 1, &second, 0, 0, NULL, &surface) == SI_INVALID_ARGUMENT);
  si_surface_file_close(file);
  int32_t kind = -1;
  OK(si_find_kind(eix, &kind));
  CHECK(kind == SI_SURFACE_FILE);
  si_volume_close(volume);
}

static int stop(double done, void* context)
{
  CHECK(done >= 0 && done <= 1);
  ++*(int*)context;
  return 1;
}

/* Of what never ends: each box takes a tenth of a second. */
static int read_slowly(const si_reading* reading)
{
  const struct timespec tenth = { 0, 100000000 };
  nanosleep(&tenth, NULL);
  memset(reading->samples, 0, reading->bytes);
  return 1;
}

static void stops_and_refuses(void)
{
  int calls = 0;
  const si_array array = { "a", SI_UINT8, 1, NULL };
  const si_grid grid = { sizeof(grid), { 600, 600, 600 }, { 1, 1, 1 }, { 0 },
    { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { NULL }, NULL, { 0 }, { 0 }, { 0 } };
  si_run run = { .size = sizeof(run) };
  run.progress = stop;
  run.context = &calls;
  CHECK(
    si_write_volume(other, &grid, 1, &array, 1, NULL, read_slowly, NULL, NULL, &run) == SI_STOPPED);
  CHECK(calls == 1);

  si_volume* volume = NULL;
  CHECK(si_volume_open("/nowhere.nrrd", NULL, NULL, &volume) == SI_NOT_FOUND && !volume);
  CHECK(strstr(si_error(), "/nowhere.nrrd"));
  struct
  {
    si_run known;
    int64_t newer;
  } later = { { .size = sizeof(later) }, 1 };
  CHECK(si_volume_open(path, NULL, &later.known, &volume) == SI_UNSUPPORTED &&
    strstr(si_error(), "si_run"));
  later.newer = 0; /* what a newer program does not ask for */
  OK(si_volume_open(path, NULL, &later.known, &volume));
  si_volume_close(volume);
  si_run none = { 0 };
  CHECK(si_volume_open(path, NULL, &none, &volume) == SI_INVALID_ARGUMENT);
  si_volume_close(NULL);
  si_surface_free(NULL);
  CHECK(si_version() == SI_VERSION && strcmp(si_type_name(SI_FLOAT64), "float64") == 0 &&
    !si_type_name(10));
}

/* Ranks as threads, which show each other their messages between barriers. */
static pthread_barrier_t barrier;
static const void* gathered[RANKS];
static const void* const* sent[RANKS];
static int all_gather(void* context, const void* mine, void* all, size_t bytes)
{
  const int rank = *(int*)context;
  gathered[rank] = mine;
  pthread_barrier_wait(&barrier);
  for (int from = 0; from < RANKS; ++from)
    memcpy((char*)all + (size_t)from * bytes, gathered[from], bytes);
  pthread_barrier_wait(&barrier);
  return 0;
}
static int exchange(void* context, const void* const* outgoing, const size_t* outgoing_bytes,
  void* const* incoming, const size_t* incoming_bytes)
{
  const int rank = *(int*)context;
  CHECK(outgoing_bytes[rank] == 0 && incoming_bytes[rank] == 0);
  sent[rank] = outgoing;
  pthread_barrier_wait(&barrier);
  for (int from = 0; from < RANKS; ++from)
    if (incoming_bytes[from] > 0)
      memcpy(incoming[from], sent[from][rank], incoming_bytes[from]);
  pthread_barrier_wait(&barrier);
  return 0;
}

static size_t triangles_of_rank[RANKS];
static void* be_rank(void* number)
{
  const int rank = *(int*)number;
  si_ranks ranks = { sizeof(ranks), rank, RANKS, number, all_gather, exchange };
  si_run run = { .size = sizeof(run) };
  run.ranks = &ranks;
  run.threads = 1;
  si_volume* volume = open_volume(path);
  si_surface_request request = make_request();
  si_surface* surface = NULL;
  OK(si_volume_extract(volume, &request, &run, &surface));
  triangles_of_rank[rank] = surface->triangle_count;
  si_surface_free(surface);
  request.maximum_islands = 1;
  OK(si_volume_extract(volume, &request, &run, &surface));
  si_surface_free(surface);
  request.scalar.array = rank == 1 ? 9 : 0; /* an error of one is one of all */
  CHECK(si_volume_extract(volume, &request, &run, &surface) ==
    (rank == 1 ? SI_INVALID_ARGUMENT : SI_REMOTE_FAILURE));
  OK(si_volume_write(volume, other, NULL, NULL, NULL, &run));
  si_volume_close(volume);

  si_growing* growing = NULL;
  OK(si_growing_begin(raw, NULL, 0, 0, 0, &run, &growing));
  si_growing_state state = { .size = sizeof(state) };
  do
  {
    OK(si_growing_poll(growing, 0.05, &run, &state));
  } while (state.stage != SI_GROWING_READY);
  OK(si_growing_take(growing, &run, &volume));
  si_growing_free(growing);
  CHECK(si_volume_describe(volume)->level_count > 1);
  si_volume_close(volume);
  return NULL;
}

/* Raw samples under a name that says what they are. */
static void write_raw(const char* folder, const char* name, char* made)
{
  snprintf(made, 4096, "%s/%s_160x160x160_uint8.raw", folder, name);
  FILE* file = fopen(made, "wb");
  CHECK(file);
  for (int z = 0; z < 160; ++z)
    for (int y = 0; y < 160; ++y)
      for (int x = 0; x < 160; ++x)
        fputc((x + 3 * y + 5 * z) % 251, file);
  CHECK(fclose(file) == 0);
}

static void share_among_ranks(void)
{
  si_volume* volume = open_volume(path);
  si_surface_request request = make_request();
  si_surface* surface = NULL;
  OK(si_volume_extract(volume, &request, NULL, &surface));
  pthread_t threads[RANKS];
  int numbers[RANKS];
  CHECK(pthread_barrier_init(&barrier, NULL, RANKS) == 0);
  size_t triangles = 0;
  for (int rank = 0; rank < RANKS; ++rank)
  {
    numbers[rank] = rank;
    CHECK(pthread_create(&threads[rank], NULL, be_rank, &numbers[rank]) == 0);
  }
  for (int rank = 0; rank < RANKS; ++rank)
  {
    CHECK(pthread_join(threads[rank], NULL) == 0);
    CHECK(triangles_of_rank[rank] > 0);
    triangles += triangles_of_rank[rank];
  }
  CHECK(triangles == surface->triangle_count);
  si_surface_free(surface);
  si_volume_close(volume);
}

static void meet_first(void)
{
  si_growing* growing = NULL;
  si_volume* shown = NULL;
  OK(si_growing_begin(first, NULL, 0, 0, 0, NULL, &growing));
  OK(si_growing_take(growing, NULL, &shown));
  const si_grid* sampled = si_volume_grid(shown, 0);
  const int64_t* size = sampled->dimensions;
  CHECK(size[0] * size[1] * size[2] > 100000 && size[0] * size[1] * size[2] < 160 * 160 * 160);
  si_growing_state state = { .size = sizeof(state) };
  do
  {
    OK(si_growing_poll(growing, 0.01, NULL, &state));
    CHECK(state.done >= 0 && state.done <= 1 && state.text &&
      (state.stage == SI_GROWING_READY || state.text[0]));
  } while (state.stage != SI_GROWING_READY);
  si_volume* volume = NULL;
  OK(si_growing_take(growing, NULL, &volume));
  si_growing_free(growing);
  CHECK(
    si_volume_grid(volume, 0)->dimensions[0] == 160 && si_volume_describe(volume)->level_count > 3);
  CHECK(sampled->spacing[0] > 0); /* the sample stays */
  si_volume_close(shown);
  si_volume_close(volume);
}

static void stop_first(void)
{
  si_growing* growing = NULL;
  OK(si_growing_begin(stopped, NULL, 0, 0, 0, NULL, &growing));
  si_growing_stop(growing);
  si_growing_state state = { 0 };
  CHECK(si_growing_poll(growing, 0, NULL, &state) == SI_INVALID_ARGUMENT &&
    strstr(si_error(), "si_growing_state"));
  state.size = sizeof(state);
  si_result status = SI_OK;
  while (status == SI_OK && state.stage != SI_GROWING_READY)
  {
    status = si_growing_poll(growing, 0.01, NULL, &state);
  }
  CHECK(status == SI_STOPPED);
  si_volume* shown = NULL;
  OK(si_growing_take(growing, NULL, &shown)); /* the sample stays */
  si_growing_free(growing);
  CHECK(si_volume_grid(shown, 0)->dimensions[0] > 0);
  si_volume_close(shown);
}

static pthread_barrier_t at_work;

/* Its first box is there when the main thread says so. */
static int read_when_told(const si_reading* reading)
{
  int* boxes = reading->context;
  if ((*boxes)++ == 0)
  {
    pthread_barrier_wait(&at_work);
    pthread_barrier_wait(&at_work);
  }
  memset(reading->samples, 0, reading->bytes);
  return 1;
}

static void* write_when_told(void* context)
{
  const si_array array = { "a", SI_UINT8, 1, NULL };
  const si_grid grid = { sizeof(grid), { 64, 64, 64 }, { 1, 1, 1 }, { 0 },
    { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { NULL }, NULL, { 0 }, { 0 }, { 0 } };
  OK(si_write_volume(other, &grid, 1, &array, 1, NULL, read_when_told, context, NULL, NULL));
  return NULL;
}

static void refuse_forks(void)
{
  pthread_t thread;
  int boxes = 0;
  CHECK(pthread_barrier_init(&at_work, NULL, 2) == 0);
  CHECK(pthread_create(&thread, NULL, write_when_told, &boxes) == 0);
  pthread_barrier_wait(&at_work);
  const pid_t child = fork();
  if (child == 0)
  {
    si_volume* volume = NULL;
    _exit(si_volume_open(path, NULL, NULL, &volume) == SI_FORKED && strstr(si_error(), "forked")
        ? 0
        : 1);
  }
  int status = 1;
  CHECK(waitpid(child, &status, 0) == child && status == 0);
  pthread_barrier_wait(&at_work);
  CHECK(pthread_join(thread, NULL) == 0);
}

int main(int argc, char** argv)
{
  CHECK(argc == 2);
  snprintf(path, sizeof(path), "%s/waves.bvol", argv[1]);
  snprintf(other, sizeof(other), "%s/other.bvol", argv[1]);
  snprintf(eix, sizeof(eix), "%s/waves.eix", argv[1]);
  write_raw(argv[1], "raw", raw);
  write_raw(argv[1], "first", first);
  write_raw(argv[1], "stopped", stopped);
  write_and_describe();
  read_samples();
  extract();
  contour_images();
  stops_and_refuses();
  share_among_ranks();
  meet_first();
  stop_first();
  refuse_forks();
  puts("all is as it is promised");
  return EXIT_SUCCESS;
}
