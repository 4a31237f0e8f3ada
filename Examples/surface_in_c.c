/* SPDX-License-Identifier: BSD-3-Clause
 *
 * Prints what a volume is, reads its middle slice, and saves an isosurface (.stl, .ply, .glb or .obj).
 *
 *     cc -std=c99 surface_in_c.c -lscalable_isosurface -o surface_in_c
 *     ./surface_in_c head.nii.gz 300 head.obj
 */
#include <scalable_isosurface.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

/* Ends the program with what the library says of a call that has failed. */
static void check(si_result status)
{
  if (status != SI_OK)
  {
    fprintf(stderr, "%s\n", si_error());
    exit(EXIT_FAILURE);
  }
}

static int show_progress(double done, void* context)
{
  fprintf(stderr, "%s: %.0f %%\n", (const char*)context, 100 * done);
  return 0; /* go on */
}

int main(int argc, char** argv)
{
  if (argc != 4)
  {
    fprintf(stderr, "usage: surface_in_c VOLUME ISOVALUE OUTPUT\n");
    return EXIT_FAILURE;
  }
  si_run run = { .size = sizeof(run) };
  run.progress = show_progress;
  run.context = argv[1];
  si_volume* volume = NULL;
  check(si_volume_open(argv[1], NULL, &run, &volume));

  const si_array* array = si_volume_describe(volume)->arrays;
  const si_grid* grid = si_volume_grid(volume, 0);
  printf("%s: %" PRId64 " x %" PRId64 " x %" PRId64 " %s, spacing %g %g %g %s\n", array->name,
    grid->dimensions[0], grid->dimensions[1], grid->dimensions[2], si_type_name(array->type),
    grid->spacing[0], grid->spacing[1], grid->spacing[2], grid->length_unit);

  si_box slice = { .size = sizeof(slice) }; /* of array 0, at time step 0 and level 0 */
  slice.high[0] = grid->dimensions[0];
  slice.high[1] = grid->dimensions[1];
  slice.low[2] = grid->dimensions[2] / 2;
  slice.high[2] = slice.low[2] + 1;
  static const size_t sizes[] = { 1, 1, 2, 2, 4, 4, 8, 8, 4,
    8 }; /* of the types, by their numbers */
  const size_t bytes =
    (size_t)(slice.high[0] * slice.high[1]) * (size_t)array->components * sizes[array->type];
  void* samples = malloc(bytes);
  check(samples ? si_volume_read(volume, &slice, samples, bytes, &run) : SI_OK);
  free(samples);

  const double isovalue = atof(argv[2]);
  si_surface_request request = { .size = sizeof(request) };
  request.isovalue_count = 1;
  request.isovalues = &isovalue;
  request.normals = 1;
  si_surface* surface = NULL;
  check(si_volume_extract(volume, &request, &run, &surface));
  printf("the surface of %g has %zu triangles\n", isovalue, surface->triangle_count);
  check(si_surface_save(surface, argv[3], array->name, grid->length_unit, &run));
  si_surface_free(surface);
  si_volume_close(volume);
  return EXIT_SUCCESS;
}
