/* SPDX-License-Identifier: BSD-3-Clause */
#ifndef SCALABLE_ISOSURFACE_H
#define SCALABLE_ISOSURFACE_H

/*
 * Isosurfaces of volumes far larger than memory, for C99 and for whatever calls C.
 *
 *     si_volume* volume = NULL;
 *     si_surface* surface = NULL;
 *     double isovalue = 300;
 *     si_surface_request request = { .size = sizeof(request) };
 *     request.isovalues = &isovalue;
 *     request.isovalue_count = 1;
 *     if (si_volume_open("head.nii.gz", NULL, NULL, &volume) != SI_OK ||
 *         si_volume_extract(volume, &request, NULL, &surface) != SI_OK)
 *       fprintf(stderr, "%s\n", si_error());
 *     si_surface_free(surface);
 *     si_volume_close(volume);
 *
 * Documentation/reference/c.md is the guide, Examples/surface_in_c.c a program of a page.
 *
 * Errors. Functions that can fail return a status: SI_OK, which is 0, or what is wrong. si_error() then has a
 * sentence that names the file and the reason. What a function gives is untouched then, unless it says otherwise.
 * No exception of C++ leaves the library.
 *
 * Order. Vertices, sizes and steps are in the order x, y, z. Samples lie x fastest, then y, then z: the sample of
 * vertex (x, y, z) of a box of nx * ny * nz vertices is number x + nx * (y + ny * z). The components of a sample
 * lie together. Points of the world are x, y, z.
 *
 * Text is UTF-8 and ends with 0. Names of files are the bytes that the system has.
 *
 * Ownership. An argument is read during the call alone, unless it is a handle. What a function gives by a pointer
 * to a pointer belongs to the caller, who gives it back to the function that its type names; that takes NULL, too.
 * What a structure points to lives as long as the structure.
 *
 * Handles, and pointers to what a function gives, are not NULL.
 *
 * Threads. Functions may be called by any number of threads at once, also with the same handle; but a handle is
 * given back once, when no other call uses it, and a si_growing belongs to one thread at a time. Callbacks are
 * called by the calling thread, but for si_reader, and never by two threads at once. A process that was forked
 * while a call was at work in another thread gets SI_FORKED of every later one.
 *
 * Versions. A structure begins with its size in bytes, as the caller was compiled: `si_run run = { .size = sizeof(run) };`
 * leaves all else 0, which always means the usual. Later versions append members, and understand structures of
 * earlier ones. A structure that the library gives may be larger than the caller knows. si_array, si_scalar,
 * si_values, si_islands and si_path have no size, and never change.
 */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C"
{
#endif

#if defined(__GNUC__)
#  define SI_API __attribute__((visibility("default")))
#else
#  define SI_API
#endif

  /* ---------------------------------------------------------------------------------------------------------- */
  /* The library */

  /* Major * 10000 + minor * 100 + patch. A library serves programs of its major version that are not newer. */
#define SI_VERSION 10000

  /* That of the library which is loaded. */
  SI_API int32_t si_version(void);

  typedef int32_t si_result;
  enum
  {
    SI_OK = 0,
    SI_INVALID_ARGUMENT = 1, /* an argument makes no sense */
    SI_NOT_FOUND = 2,        /* there is no such file, store or array */
    SI_IO_ERROR = 3,         /* the system refused */
    SI_DISK_FULL = 4,
    SI_CORRUPT = 5,     /* a file is damaged, or was changed since it was opened */
    SI_UNSUPPORTED = 6, /* a format that is not read, or is newer than the library */
    SI_OUT_OF_MEMORY = 7,
    SI_STOPPED = 8,        /* a callback said so */
    SI_REMOTE_FAILURE = 9, /* another rank failed, and has its own error */
    SI_FORKED = 100        /* see "Threads" */
  };

  /* What the last call of this thread that failed has to say. It lives until the next call of this thread. Never
   * NULL. */
  SI_API const char* si_error(void);

  /* Types of samples and values. */
  enum
  {
    SI_INT8 = 0,
    SI_UINT8 = 1,
    SI_INT16 = 2,
    SI_UINT16 = 3,
    SI_INT32 = 4,
    SI_UINT32 = 5,
    SI_INT64 = 6,
    SI_UINT64 = 7,
    SI_FLOAT32 = 8,
    SI_FLOAT64 = 9
  };

  /* "int8" ... "float64"; NULL if no type has this number. Static. */
  SI_API const char* si_type_name(int32_t type);

  /* ---------------------------------------------------------------------------------------------------------- */
  /* How a call runs */

  /*
   * The ranks of a parallel program, each of which calls the same functions in the same order with the same
   * arguments, but for what belongs to a rank. With MPI, all_gather is MPI_Allgather of bytes, and exchange is
   * MPI_Isend and MPI_Irecv of the messages that are not empty. Both are called by the thread that calls the
   * library, and return 0; what else they return ends the call with SI_IO_ERROR on this rank.
   */
  typedef struct si_ranks
  {
    size_t size;
    int32_t rank;  /* of this process, from 0 on */
    int32_t count; /* of all of them */
    void* context;
    /* Gives each rank the `bytes` of all, in the order of the ranks; as many of each. */
    int (*all_gather)(void* context, const void* mine, void* all, size_t bytes);
    /* Sends outgoing[r] to rank r, and fills incoming[r] with what rank r sends. The sizes are those that the other
     * side has, too. Messages to itself are not this function's: their sizes are 0. */
    int (*exchange)(void* context, const void* const* outgoing, const size_t* outgoing_bytes,
      void* const* incoming, const size_t* incoming_bytes);
  } si_ranks;

  /* All may be 0. NULL in place of a structure is the same. */
  typedef struct si_run
  {
    size_t size;
    int32_t threads; /* at most so many; 0: as many as there are cores */
    /* The finished part of the work, 0 to 1; at most ten times a second, and not in the first tenth. What is not 0
     * stops it, and the call returns SI_STOPPED. */
    int (*progress)(double done, void* context);
    /* Something that the user should know; the work goes on unless this is not 0. */
    int (*warn)(const char* message, void* context);
    void* context; /* for both */
    /* NULL: this process alone. Functions that take ranks into account say so; they are collective then. */
    const si_ranks* ranks;
  } si_run;

  /* ---------------------------------------------------------------------------------------------------------- */
  /* What is in a file */

  enum
  {
    SI_BLOCKED_VOLUME = 0, /* a .bvol */
    SI_SURFACE_FILE = 1,   /* an edge-index file, .eix: si_surface_file_open */
    SI_SOURCE = 2          /* of another format, perhaps of one that is not read */
  };

  /* Looks at a name and the first bytes. SI_NOT_FOUND if there is no such file or folder. */
  SI_API si_result si_find_kind(const char* name, int32_t* kind);

  /* Texts. */
  typedef struct si_texts
  {
    size_t size;
    size_t count;
    const char* const* texts;
  } si_texts;
  SI_API void si_texts_free(si_texts* texts);

  /* The datasets in a file of another format: each opens as NAME:DATASET. None if it has one volume. */
  SI_API si_result si_list_datasets(const char* name, const si_run* run, si_texts** datasets);

  /* The attributes of a dataset in HDF5, Zarr, N5 or DICOM, as an object of JSON, in one text; "" if there are none.
   * `axes` as in si_opening, or NULL. */
  SI_API si_result si_read_attributes(const char* name, const char* axes, const si_run* run, si_texts** json);

  /* ---------------------------------------------------------------------------------------------------------- */
  /* Volumes */

  /* What indexing has fetched of an address, one call after another (si_opening). For the last name that it was used
   * with; one call at a time. */
  typedef struct si_fetching si_fetching;
  SI_API si_fetching* si_fetching_new(void);
  SI_API void si_fetching_free(si_fetching* fetching);

  /* How a volume is opened. What is NULL is as the file says. */
  typedef struct si_opening
  {
    size_t size;
    const char* axes;         /* what the axes of a dataset are, the slowest first, of the letters x y z t c */
    const char* index_folder; /* where the index of a file of another format may be; NULL: beside it */
    const double* spacing;    /* three, in place of the file's */
    const double* origin;     /* three, of the first vertex */
    const char* length_unit;  /* "mm", "um", ... */
    int32_t local_stores; /* not 0: stores may be on disks that one rank reaches, and ranks share whole stores */
    const double* region; /* x0 x1 y0 y1 z0 z1: only the part of a file of another format that has this box; NULL: all */
    uint64_t fetch_budget; /* bytes that indexing may fetch from an address; 0: no limit */
    si_fetching* fetching; /* what was fetched before counts, too; NULL: fetch_budget counts from 0 */
  } si_opening;

  typedef struct si_volume si_volume;

  /*
   * Opens a blocked volume (.bvol), or a file or folder of another format: MetaImage, NRRD, NIfTI, MRC, TIFF, DICOM,
   * HDF5, NetCDF, Zarr, N5, raw samples. What is meant within a file follows a colon: "run.h5:/entry/data",
   * "scan.raw:512x512x300,uint16". A file that has a current index (si_write_index) is opened by it. `opening`
   * and `run` may be NULL. Threads of `run` are those that make blocks of a file without an index.
   */
  SI_API si_result si_volume_open(
    const char* name, const si_opening* opening, const si_run* run, si_volume** volume);
  SI_API void si_volume_close(si_volume* volume);

  typedef struct si_array
  {
    const char* name;
    int32_t type;
    int32_t components; /* of a sample */
    const char* unit;   /* of the samples, as "HU"; "" if it is not known */
  } si_array;

  typedef struct si_volume_info
  {
    size_t size;
    const char* path; /* of the volume, or of the index that was opened in its place */
    size_t array_count;
    const si_array* arrays;
    size_t step_count;    /* time steps, at least 1 */
    const double* times;  /* of each; NaN where the file does not tell */
    size_t level_count;   /* levels of detail: 0 is all samples, each next one every second of them on each axis */
    const char* left_out; /* what of the file is not read; "" if all is */
  } si_volume_info;
  /* Lives until the volume is closed. */
  SI_API const si_volume_info* si_volume_describe(const si_volume* volume);

  /* Where samples lie: vertex (i, j, k) at origin + direction * (spacing * (i, j, k)), or on lines. A volume that
   * is written needs size to direction. */
  typedef struct si_grid
  {
    size_t size;
    int64_t dimensions[3]; /* vertices on each axis */
    double spacing[3];
    double origin[3];    /* of the first vertex */
    double direction[9]; /* row by row; its columns are the directions of the axes */
    const double* lines[3]; /* of a rectilinear grid the coordinates on each axis; else NULL */
    const char* length_unit; /* "" or NULL if it is not known */
    int64_t chunk[3];       /* the vertices that are best read together; 0: any */
    int64_t first[3];       /* the number of the first vertex on each axis, where images count from another one than 0; */
    double zero[3];         /* then vertex 0 is here, and the origin says nothing */
  } si_grid;
  /* Of a level. Lives until the volume is closed. NULL if there is no such level. */
  SI_API const si_grid* si_volume_grid(si_volume* volume, size_t level);

  /* Samples at every stride-th vertex of the box [low, high), from its low corner on. */
  typedef struct si_box
  {
    size_t size;
    size_t array;
    size_t step; /* time step */
    size_t level;
    int64_t low[3];
    int64_t high[3];
    int64_t stride[3];         /* 0 is 1 */
    size_t component_count;    /* 0: all */
    const int32_t* components; /* in the order of the result */
  } si_box;
  /* Fills `samples`, which has room for `bytes`: those of the type * components * vertices, else it is
   * SI_INVALID_ARGUMENT. A slice is a box of one vertex on an axis. What it has after an error is undefined. */
  SI_API si_result si_volume_read(
    si_volume* volume, const si_box* box, void* samples, size_t bytes, const si_run* run);

  /* As a component: the magnitude of an array's tuples. */
#define SI_MAGNITUDE (-1)

  /* The scalar that is contoured: `component` of `array`, at a time step and a level. */
  typedef struct si_scalar
  {
    size_t array;
    int32_t component;
    size_t step;
    size_t level;
  } si_scalar;

  /* Fills `range` with the minimum and the maximum of the finite samples; NaN if there is none. Of a file without an
   * index, these and all that follow read the time step into memory first, in blocks, and keep them. */
  SI_API si_result si_volume_range(
    si_volume* volume, const si_scalar* scalar, const si_run* run, double range[2]);

  /* Values at points of the world, x y z each, interpolated: `values` has `count` tuples of the array's type, and
   * `inside` (may be NULL) 1 for each point within the grid, else 0; values of points beyond it are left as they were.
   * The component of the scalar does not count: tuples have all. `nearest`: not 0 for the nearest sample. */
  SI_API si_result si_volume_probe(si_volume* volume, const si_scalar* scalar, int nearest, size_t count,
    const double* points, void* values, uint8_t* inside, const si_run* run);

  /* A plane's samples: an image of dimensions[0] * dimensions[1] points. */
  typedef struct si_slice
  {
    size_t size;
    const si_grid* grid; /* one vertex on the third axis */
    size_t level;
    void* values;          /* tuples of the array's type */
    const uint8_t* inside; /* 1 for points within the volume, else 0; there the values are 0 or NaN */
  } si_slice;
  /* Cuts the array by the plane with this origin and normal, at the finest level from the scalar's on at which it
   * has at most `most_points` (0: any number). `*slice` becomes NULL if the plane does not meet the volume. */
  SI_API si_result si_volume_slice(si_volume* volume, const si_scalar* scalar, const double origin[3],
    const double normal[3], double most_points, const si_run* run, si_slice** slice);
  SI_API void si_slice_free(si_slice* slice);

  /* ---------------------------------------------------------------------------------------------------------- */
  /* Surfaces */

  /* What the isosurface of each isovalue is. A quantity that is not known is NULL, else it has `count` values. */
  typedef struct si_spectrum
  {
    size_t size;
    size_t count;
    const double* isovalues; /* ascending, in equal steps; at most 2048 */
    const uint64_t* triangles;
    const uint64_t* cells;  /* that the surface crosses */
    const uint64_t* blocks; /* that it crosses */
    const uint64_t* bytes;  /* that are read of them */
    const double* area;     /* estimated */
    const double* volume;   /* estimated, where samples are at least the isovalue */
  } si_spectrum;
  SI_API si_result si_volume_spectrum(
    si_volume* volume, const si_scalar* scalar, const si_run* run, si_spectrum** spectrum);
  SI_API void si_spectrum_free(si_spectrum* spectrum);
  /* An isovalue to begin with: that which divides the samples into the two classes that differ most; NaN if there are
   * not two values. */
  SI_API si_result si_volume_propose(
    si_volume* volume, const si_scalar* scalar, const si_run* run, double* isovalue);

  enum
  {
    SI_BY_TRIANGLES = 0, /* at full resolution */
    SI_BY_AREA = 1,
    SI_BY_VOLUME = 2 /* that the island encloses */
  };

  /* Which isosurfaces. Samples of at least the isovalue are inside. Functions that take a request are collective with
   * ranks, which give the same one. */
  typedef struct si_surface_request
  {
    size_t size;
    si_scalar scalar;
    size_t isovalue_count;
    const double* isovalues;
    const double* region;             /* x0 x1 y0 y1 z0 z1: only blocks that meet this box, of an address without an
                                       * index only cells; NULL: all */
    size_t attribute_count;           /* other arrays, interpolated at the points */
    const size_t* attributes;         /* their numbers */
    int32_t normals;                  /* not 0: from the gradients of the samples */
    int32_t global_ids;               /* not 0: numbers of the points that are the same on all ranks */
    int32_t points;                   /* 0, SI_FLOAT32 or SI_FLOAT64; 0: float32 unless that is too coarse */
    int32_t closed;                   /* 1: closed at the sides of the volume; -1: around what is below the isovalue */
    int32_t drop_degenerate_triangles; /* not 0; those of closed surfaces always are */
    int32_t island_size;              /* SI_BY_TRIANGLES, ... */
    double minimum_island;            /* smaller connected parts are left out */
    uint64_t maximum_islands;         /* of each isovalue, the largest; 0: all */
    uint64_t maximum_triangles;       /* of all ranks; 0: any number. A coarser level is taken if need be, */
    double maximum_seconds;           /* likewise if it is expected to take longer */
    int32_t vtk_version;       /* as 902, for VTK 9.2: offsets, the width of corners and the last bits of normals are as there */
    int32_t polygons;          /* not 0: one for each sheet in a cell, in place of triangles */
    int32_t skip_not_a_number; /* not 0: there is no surface in cells with a NaN; 0: NaN is below the isovalue */
    int32_t island_ids;        /* not 0: the island of each triangle */
    const double* island_point; /* x y z: of the islands that are left only the one that is nearest; NULL: all */
    size_t half_space_count;    /* only blocks that meet all of them: */
    const double* half_spaces;  /* four numbers each, a normal n and d: points p with n * p of at most d */
  } si_surface_request;

  /* How many triangles there are in the whole volume, without the islands' and the region's limits: an estimate, but
   * exact at isovalues of the spectrum. */
  SI_API si_result si_volume_estimate(
    si_volume* volume, const si_surface_request* request, const si_run* run, double* triangles);

  /* Boxes of vertices, x0 x1 y0 y1 z0 z1 each; the ends are beyond the last vertex. */
  typedef struct si_boxes
  {
    size_t size;
    size_t count;
    const int64_t* boxes;
  } si_boxes;
  /* The blocks that the isosurfaces cross, of several ranks this one's; none of their samples is read. At a coarse level some may be empty. */
  SI_API si_result si_volume_find_blocks(
    si_volume* volume, const si_surface_request* request, const si_run* run, si_boxes** boxes);
  SI_API void si_boxes_free(si_boxes* boxes);

  /* Values on the points of a surface: float64 of samples of float64, else float32. */
  typedef struct si_values
  {
    const char* name;
    int32_t type;
    int32_t components;
    void* values;
  } si_values;

  /* Of the surface of an isovalue, on all ranks, before and after some were left out. */
  typedef struct si_islands
  {
    uint64_t islands;
    uint64_t kept_islands;
    uint64_t triangles;
    uint64_t kept_triangles;
  } si_islands;

  /* Where a block is in a tree: its number among its siblings, from the root on. */
  typedef struct si_path
  {
    size_t count;
    const int64_t* numbers;
  } si_path;

  /* Triangles that share their points. The memory is that in which the surface was made; the caller may change what
   * is in it. */
  typedef struct si_surface
  {
    size_t size;
    size_t point_count;
    size_t triangle_count;
    int32_t point_type;  /* SI_FLOAT32 or SI_FLOAT64 */
    int32_t corner_type; /* SI_INT32, or SI_INT64 if that does not suffice */
    void* points;        /* x y z each */
    void* corners;       /* three numbers of points a triangle, counter-clockwise seen from low values */
    float* normals;      /* x y z each, from high to low values; NULL if they were not asked for */
    int64_t* global_ids; /* NULL if they were not asked for */
    size_t part_count;   /* one for each isovalue, in the order of the request */
    const double* isovalues;
    const int64_t* first_points;    /* part_count + 1: part n has the points from first_points[n] on, */
    const int64_t* first_triangles; /* and the triangles from first_triangles[n] on */
    size_t attribute_count;
    const si_values* attributes;
    size_t level; /* coarser than asked for if a limit wanted it */
    const void* offsets; /* triangle_count + 1 of corner_type: polygon n has the corners from number offsets[n] on; NULL
                          * unless vtk_version or polygons were asked for */
    const int64_t* island_ids; /* of each triangle: the place of its island among all, 0 is the largest; or NULL */
    const si_islands* islands; /* part_count; NULL if islands were not looked for */
    size_t block_count;        /* of images that are several fields (si_images_extract); 0: there is one */
    const si_path* blocks;     /* of all ranks, ascending */
    const int32_t* block_ids;  /* of each point: the number of its block */
  } si_surface;
  SI_API void si_surface_free(si_surface* surface);

  /* Extracts isosurfaces; of several ranks, each gets its part. */
  SI_API si_result si_volume_extract(
    si_volume* volume, const si_surface_request* request, const si_run* run, si_surface** surface);

  /* Saves a surface as .stl, .ply, .glb or .obj, by the end of the path: all but .obj in binary, with normals if it has
   * them. A file that is there is replaced when the new one is complete. `name` is that of the surface, and `length_unit`
   * that of the points, for .glb, which is in metres; NULL: none, and mm. A point that is not finite is
   * SI_INVALID_ARGUMENT. */
  SI_API si_result si_surface_save(const si_surface* surface, const char* path, const char* name,
    const char* length_unit, const si_run* run);

  /* ---------------------------------------------------------------------------------------------------------- */
  /* Images in memory */

  /* Samples of an image, or of a rectilinear grid, that this rank has. Pieces that meet are one image, on whichever
   * ranks they are; samples that several have are the same in all of them. */
  typedef struct si_piece
  {
    size_t size;
    const si_grid* grid;  /* of these samples; `first` and `zero` are their place in the whole image */
    const int64_t* whole; /* x0 x1 y0 y1 z0 z1 of that, inclusive, counted as `first` is; NULL: not known */
    const int64_t* own;   /* x0 x1 y0 y1 z0 z1 of the vertices [x0, x1) of these samples between which this piece is
                           * contoured: others have the rest, too; NULL: all of them */
    size_t array_count;
    const si_array* arrays;
    const void* const* samples;     /* of each array: its tuples */
    const uint8_t* hidden_cells;    /* of each cell: not 0 where there is no surface; NULL: there is everywhere */
    const uint8_t* hidden_vertices; /* likewise */
    si_path block;     /* pieces of one image in several blocks may be fields of their own, as those of an ensemble */
    uint64_t identity; /* another one whenever samples at the same address are others */
  } si_piece;

  /* Keeps what speeds up the next surface of the same samples: value ranges. It keeps no samples. */
  typedef struct si_images si_images;
  SI_API si_result si_images_create(si_images** images);
  SI_API void si_images_free(si_images* images);
  /* Extracts isosurfaces of all ranks' pieces; each rank gets those of its own. The scalar and the attributes are
   * numbers of arrays in each piece. There is one level and one time step, and no limit of triangles or seconds.
   * Collective with ranks; a rank may have no pieces, and no attributes then. */
  SI_API si_result si_images_extract(si_images* images, size_t count, const si_piece* const* pieces,
    const si_surface_request* request, const si_run* run, si_surface** surface);

  /* ---------------------------------------------------------------------------------------------------------- */
  /* Edge-index files: surfaces in a few bits a point */

  enum
  {
    SI_LOSSLESS = 0,
    SI_BOUNDED = 1,  /* points move along their edges by at most maximum_error of its length */
    SI_QUANTIZED = 2, /* samples are rounded to quantization_bits over the range of their array */
    SI_SMALLEST = 3 /* the smaller of both, block by block */
  };
  typedef struct si_coding
  {
    size_t size;
    int32_t mode;
    int32_t preview_level; /* a coarse surface of every 2^level-th vertex is kept, too; 0: none */
    double maximum_error;  /* 0 is 0.01 */
    double array_error;    /* that values of attributes may change; 0: none */
    double normal_error;   /* of a component; 0 is 0.005, below 0: none */
    int32_t profile;       /* 0: small; 3: working, which is read and written faster, and larger */
    uint64_t memory;       /* bytes that a rank holds before it writes; 0 is 256 MiB */
    int32_t quantization_bits; /* 2 to 24; 0 is 12 */
  } si_coding;

  /* Writes the isosurfaces as an edge-index file (.eix). A file that is there is replaced when the new one is complete.
   * `coding` may be NULL. Several ranks write one file. */
  SI_API si_result si_volume_write_surface(si_volume* volume, const si_surface_request* request, const char* path,
    const si_coding* coding, const si_run* run);

  typedef struct si_surface_file si_surface_file;
  SI_API si_result si_surface_file_open(const char* path, const si_run* run, si_surface_file** file);
  SI_API void si_surface_file_close(si_surface_file* file);

  typedef struct si_surface_file_info
  {
    size_t size;
    size_t isovalue_count;
    const double* isovalues;
    const char* array;  /* that was contoured */
    const char* source; /* where the samples came from, in the writer's words */
    double time;        /* of the samples; NaN if it is not known */
    const char* length_unit;
    size_t attribute_count;
    const char* const* attributes; /* names of the arrays on the points */
    int32_t has_preview;
    const char* missing; /* what the file lacks; "" if nothing */
  } si_surface_file_info;
  /* Lives until the file is closed. */
  SI_API const si_surface_file_info* si_surface_file_describe(const si_surface_file* file);

  /* Decodes the surface of the isovalues with these numbers, in this order; of all if there are none. `preview`: not 0
   * for the coarse surface, which has no attributes. `normals`: not 0 for those of the file, or else of the
   * triangles. */
  SI_API si_result si_surface_file_read(si_surface_file* file, size_t isovalue_count, const size_t* isovalues,
    int preview, int normals, const si_run* run, si_surface** surface);

  /* What is read of a file. */
  typedef struct si_surface_reading
  {
    size_t size;
    int32_t preview;     /* not 0: the coarse surface */
    int32_t normals;     /* not 0: those of the file, or else of the triangles */
    int32_t global_ids;  /* not 0: numbers of the points that are the same in all pieces */
    int32_t vtk_version; /* as in si_surface_request */
    int32_t piece;       /* of piece_count, which have about as many points each */
    int32_t piece_count; /* 0 is 1 */
    const double* region; /* x0 x1 y0 y1 z0 z1: only blocks that reach into this box; NULL: all */
  } si_surface_reading;
  /* Decodes the surfaces of all isovalues, or a piece of them. */
  SI_API si_result si_surface_file_read_piece(
    si_surface_file* file, const si_surface_reading* reading, const si_run* run, si_surface** surface);

  /* ---------------------------------------------------------------------------------------------------------- */
  /* Writing volumes */

  typedef struct si_settings
  {
    size_t size;
    int32_t block_size;   /* cells a side: 16, 32 or 64; 0 is 32 */
    int32_t codec_level;  /* 0: the codec's own */
    const char* codec;    /* "none", "lz4" or "zstd"; NULL is "lz4" */
    uint32_t stores;      /* 0: as many as there are ranks */
    uint32_t replicas;    /* stores that have each block; 0 is 1 */
    int32_t append;       /* not 0: to the volume that is there */
    uint64_t memory;      /* bytes that a rank may take; 0 is 1 GiB */
    int32_t distribution; /* of blocks over stores: 0 greedy, 1 random, 2 slab, 3 balanced */
    uint64_t random_seed; /* of the random one */
  } si_settings;

  /* What a reader is asked for: samples of the box [low, high) of an array at a time step. */
  typedef struct si_reading
  {
    size_t size;
    void* context; /* the caller's */
    size_t step;
    size_t array;
    int64_t low[3];
    int64_t high[3];
    void* samples; /* to be filled with tuples of the array's type */
    size_t bytes;  /* their number */
  } si_reading;
  /* Fills the samples, and returns 1. Anything else is an error, and ends the write. Called by any thread, but by one at
   * a time; for some boxes more than once. */
  typedef int (*si_reader)(const si_reading* reading);

  /*
   * Writes a blocked volume of samples that `reader` gives, in memory of constant size. `times` has the time of each of
   * `step_count` steps, or NaN; NULL: they have none. All steps become visible together; a volume that is there is
   * replaced then. `settings` may be NULL. Collective with ranks, each of which is asked for boxes of all of the volume.
   */
  SI_API si_result si_write_volume(const char* path, const si_grid* grid, size_t array_count,
    const si_array* arrays, size_t step_count, const double* times, si_reader reader, void* context,
    const si_settings* settings, const si_run* run);

  /* The same of all arrays and time steps of a volume. `grid` may be NULL, and `times`: those of the volume. */
  SI_API si_result si_volume_write(si_volume* volume, const char* path, const si_grid* grid, const double* times,
    const si_settings* settings, const si_run* run);

  /* ---------------------------------------------------------------------------------------------------------- */
  /* Volumes in place */

  /* Indexes a file of another format where it lies: a small blocked volume beside it, or in the folder of `opening`, which
   * may be NULL. Nothing is written if there is a current one. `memory`: bytes that it may take; 0 is 1 GiB. What of the
   * file is left out is a warning. */
  SI_API si_result si_write_index(
    const char* name, const si_opening* opening, uint64_t memory, const si_run* run);

  /* First contact with a file of any size: a sample of it after about a second, while the index is written beside. */
  typedef struct si_growing si_growing;

  enum
  {
    SI_GROWING_WORKS = 0, /* what was taken last is what there is */
    SI_GROWING_LARGER = 1, /* there is a larger sample to be taken */
    SI_GROWING_READY = 2   /* the volume is to be taken; nothing else follows */
  };
  typedef struct si_growing_state
  {
    size_t size;
    int32_t stage;
    double done;         /* of the index, 0 to 1 */
    double seconds_left; /* negative if they are not known */
    double share;        /* of the file that the sample which is shown is of */
    const char* text;    /* what it is of the file; lives until the next call with the handle */
  } si_growing_state;

  /* Reads a sample of the time step `step` in about `seconds` (0 is 1), and begins to write the index. Of a small file, or
   * of one that has a current index, the volume is ready at once. Collective with ranks, as are the next two. */
  SI_API si_result si_growing_begin(const char* name, const si_opening* opening, size_t step, double seconds,
    uint64_t memory, const si_run* run, si_growing** growing);
  /* Waits for something new, at most `seconds`, and tells the state. An error is that of writing the index: the sample
   * stays, and nothing follows. Where there are several ranks, the index is written during these calls alone. */
  SI_API si_result si_growing_poll(
    si_growing* growing, double seconds, const si_run* run, si_growing_state* state);
  /* The volume that is to be shown now: the sample, a larger one, or that of the index. */
  SI_API si_result si_growing_take(si_growing* growing, const si_run* run, si_volume** volume);
  /* Asks for the end, without waiting: the next poll returns SI_STOPPED. What is written is kept for the next try. */
  SI_API void si_growing_stop(si_growing* growing);
  /* Stops it, and waits for that. Volumes that were taken stay valid. */
  SI_API void si_growing_free(si_growing* growing);

#ifdef __cplusplus
}
#endif

#endif
