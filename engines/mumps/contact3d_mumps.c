/* contact3d-mumps: a linear engine for contact3d-pipe whose sparse Cholesky factor lives on several machines.
 *
 * It factorises a symmetric positive definite matrix A with MUMPS in single precision, and answers S = B A^-1 B^T,
 * A^-1 b and C A^-1 B^T on its standard output to requests on its standard input (engines/protocol.md, version 1). Only
 * process 0 reads and writes; it tells the others which MUMPS job comes next.
 *
 * Build:  make            (needs mpicc and the MPI build of MUMPS; Debian: libmumps-dev libopenmpi-dev)
 * Start:  mpirun -n 4 contact3d-mumps [--low-rank EPS]
 *         OPENBLAS_NUM_THREADS=1 in the environment, where there are as many processes as cores.
 *
 * S is minus the Schur complement of the zero block in [[A, B^T], [B, 0]], so MUMPS makes it along with the factor.
 */

#include <limits.h>
#include <math.h>
#include <mpi.h>
#include <smumps_c.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the protocol is little-endian");
_Static_assert(sizeof(MUMPS_INT) == sizeof(uint32_t), "indices are read straight into MUMPS' integers");

enum { LEAVE = 0, FACTORISE = 1, SOLVE = 2, COMPLIANCE = 3 };
typedef enum { DONE = 0, NOT_POSITIVE = 1, NO_MEMORY = 2, OTHER = 3 } Status;

/* Jobs of MUMPS; NO_JOB sends the other processes home. */
enum { JOB_BEGIN = -1, JOB_END = -2, NO_JOB = 0, JOB_ANALYSE = 1, JOB_FACTORISE = 2, JOB_SOLVE = 3 };

enum {
    BLOCK = 64,             /* right-hand sides at once */
    CHUNK = 8192,           /* numbers at once while reading */
    MOST_RELAXATION = 1000, /* per cent of workspace beyond MUMPS' estimate, after which it gives up */
};

#define ICNTL(i) mumps.icntl[(i) - 1]
#define CNTL(i) mumps.cntl[(i) - 1]
#define INFOG(i) mumps.infog[(i) - 1]

/* A sparse matrix by lines: the columns of A's lower triangle, or the rows of B or C. */
typedef struct {
    uint64_t lines, entries;
    uint64_t *start;
    uint32_t *index;
    float *value;
} Sparse;

typedef struct {
    SMUMPS_STRUC_C mumps;
    double low_rank; /* tolerance of block low-rank compression; negative: off */
    int processes;
    bool begun; /* MUMPS has an instance, which JOB_END must end */
    bool ready; /* there is a factor */
    uint64_t n; /* of the last FACTORISE, failed or not: so long are the right-hand sides that may follow */
    Sparse b;   /* indices count from 1, as MUMPS wants them */
} Engine;

/* ---- standard input and output ---- */

static void stop(const char *why)
{
    fprintf(stderr, "contact3d-mumps: %s\n", why);
    MPI_Abort(MPI_COMM_WORLD, 1);
    exit(1);
}

static void get(void *to, size_t bytes)
{
    if (fread(to, 1, bytes, stdin) != bytes)
        stop("standard input ended inside a request");
}

static uint64_t get_u64(void)
{
    uint64_t value;
    get(&value, sizeof value);
    return value;
}

static void put(const void *from, size_t bytes)
{
    if (fwrite(from, 1, bytes, stdout) != bytes)
        stop("standard output is closed");
}

static void put_u64(uint64_t value)
{
    put(&value, sizeof value);
}

static void answer_text(Status status, const char *text)
{
    put_u64(status);
    put_u64(strlen(text));
    put(text, strlen(text));
}

/* ---- memory; what does not fit is NULL, and its bytes in the input are passed over ---- */

static size_t size_of(uint64_t count, size_t each)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, each, &bytes))
        stop("an array in a request is longer than memory can be");
    return bytes;
}

static void *new_array(uint64_t count, size_t each)
{
    size_t bytes = size_of(count, each);
    return malloc(bytes > 0 ? bytes : 1);
}

static void get_or_skip(void *to, size_t bytes)
{
    char scrap[CHUNK];
    if (to) {
        get(to, bytes);
        return;
    }
    for (size_t part; bytes > 0; bytes -= part) {
        part = bytes < sizeof scrap ? bytes : sizeof scrap;
        get(scrap, part);
    }
}

static void *get_array(uint64_t count, size_t each)
{
    void *array = new_array(count, each);
    get_or_skip(array, size_of(count, each));
    return array;
}

/* Numbers of 8 bytes in the input, of 4 in memory. */
static float *get_rounded(uint64_t count)
{
    float *array = new_array(count, sizeof *array);
    double chunk[CHUNK];
    for (uint64_t done = 0, part; done < count; done += part) {
        part = count - done < CHUNK ? count - done : CHUNK;
        get(chunk, part * sizeof *chunk);
        for (size_t i = 0; array && i < part; i++)
            array[done + i] = (float)chunk[i];
    }
    return array;
}

static Sparse get_sparse(uint64_t lines, uint64_t entries)
{
    Sparse s = {.lines = lines, .entries = entries};
    s.start = get_array(lines + 1, sizeof *s.start);
    s.index = get_array(entries, sizeof *s.index);
    s.value = get_rounded(entries);
    return s;
}

static bool fits(const Sparse *s)
{
    return s->start && s->index && s->value;
}

static void free_sparse(Sparse *s)
{
    free(s->start);
    free(s->index);
    free(s->value);
    *s = (Sparse){0};
}

/* ---- what a request may not hold; NULL where nothing is wrong ---- */

static const char *fault_of_sparse(const Sparse *s, uint64_t width)
{
    if (s->start[0] != 0 || s->start[s->lines] != s->entries)
        return "offsets do not begin with 0 and end with the number of entries";
    for (uint64_t line = 0; line < s->lines; line++)
        if (s->start[line] > s->start[line + 1])
            return "offsets decrease";
    for (uint64_t at = 0; at < s->entries; at++) {
        if (s->index[at] >= width)
            return "an index is out of range";
        if (!isfinite(s->value[at]))
            return "a value is not finite in single precision";
    }
    return NULL;
}

static const char *fault_of_triangle(const Sparse *a)
{
    for (uint64_t column = 0; column < a->lines; column++)
        for (uint64_t at = a->start[column]; at < a->start[column + 1]; at++) {
            if (a->index[at] < column)
                return "an entry of A is above the diagonal";
            if (at > a->start[column] && a->index[at] <= a->index[at - 1])
                return "the rows of a column of A do not increase";
        }
    return NULL;
}

static const char *fault_of_system(const Sparse *a, const Sparse *b)
{
    if (a->lines == 0)
        return "A has no unknowns";
    if (a->lines > INT_MAX || b->lines > INT_MAX || a->lines + b->lines > INT_MAX)
        return "A and B have more than 2^31 - 1 rows";
    if (b->entries > INT_MAX)
        return "B has more than 2^31 - 1 entries";
    const char *fault = fault_of_sparse(a, a->lines);
    if (!fault)
        fault = fault_of_triangle(a);
    return fault ? fault : fault_of_sparse(b, a->lines);
}

/* ---- MUMPS ---- */

/* Process 0 says which job comes next. The others wait asleep: they may share cores with the program that asks. */
static int share_job(int job)
{
    const struct timespec nap = {.tv_nsec = 500000};
    MPI_Request request;
    int arrived = 0;
    MPI_Ibcast(&job, 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
    while (MPI_Test(&request, &arrived, MPI_STATUS_IGNORE), !arrived)
        nanosleep(&nap, NULL);
    return job;
}

/* Every process. */
static void take_part(Engine *e, int job)
{
    e->mumps.job = job;
    if (job == JOB_BEGIN) {
        e->mumps.par = 1;
        e->mumps.sym = 1;
        e->mumps.comm_fortran = (MUMPS_INT)MPI_Comm_c2f(MPI_COMM_WORLD);
    }
    smumps_c(&e->mumps);
    if (job == JOB_BEGIN)
        for (int stream = 1; stream <= 4; stream++)
            e->ICNTL(stream) = 0;
}

/* Process 0, as everything below but help_process_0. */
static Status run(Engine *e, int job)
{
    take_part(e, share_job(job));
    switch (e->INFOG(1)) {
    case -6: case -10: case -40: return NOT_POSITIVE;
    case -5: case -7: case -13: return NO_MEMORY;
    }
    return e->INFOG(1) < 0 ? OTHER : DONE;
}

static void help_process_0(Engine *e)
{
    for (int job; (job = share_job(NO_JOB)) != NO_JOB;)
        take_part(e, job);
}

static void answer_failure(const Engine *e, Status status)
{
    char text[96];
    if (status == NOT_POSITIVE) {
        put_u64(status);
        put_u64(UINT64_MAX);
    } else {
        snprintf(text, sizeof text, "MUMPS job %d: INFOG(1) = %d, INFOG(2) = %d", e->mumps.job, e->INFOG(1),
                 e->INFOG(2));
        answer_text(status, text);
    }
}

static void forget(Engine *e)
{
    if (e->begun)
        run(e, JOB_END);
    free_sparse(&e->b);
    e->begun = e->ready = false;
}

/* ---- FACTORISE ---- */

static void set_options(Engine *e)
{
    e->ICNTL(5) = 0;  /* assembled, */
    e->ICNTL(18) = 0; /* on process 0 */
    e->ICNTL(6) = 0;  /* no permutation for the sake of values */
    e->ICNTL(28) = 1; /* sequential analysis */
    e->ICNTL(7) = 1;  /* in our order */
    e->ICNTL(8) = 0;  /* no scaling */
    e->ICNTL(19) = e->b.lines > 0; /* the Schur complement, whole on process 0 */
    e->ICNTL(26) = 0; /* solve with A alone */
    if (e->low_rank >= 0) {
        e->ICNTL(35) = 2;
        e->CNTL(7) = (float)e->low_rank;
    }
}

/* A becomes [[A, B^T], [B, 0]] as MUMPS' triples; the indices of both begin with 1 from here on. */
static bool give_entries(Engine *e, Sparse *a)
{
    uint64_t nnz = a->entries, all = nnz + e->b.entries;
    uint32_t *row = realloc(a->index, size_of(all + 1, sizeof *row));
    if (row)
        a->index = row;
    float *value = realloc(a->value, size_of(all + 1, sizeof *value));
    if (value)
        a->value = value;
    MUMPS_INT *column = e->mumps.jcn = new_array(all, sizeof *column);
    if (!row || !value || !column)
        return false;
    for (uint64_t j = 0; j < e->n; j++)
        for (uint64_t at = a->start[j]; at < a->start[j + 1]; at++) {
            row[at] += 1;
            column[at] = (MUMPS_INT)(j + 1);
        }
    for (uint64_t i = 0; i < e->b.lines; i++)
        for (uint64_t at = e->b.start[i]; at < e->b.start[i + 1]; at++) {
            row[nnz + at] = (uint32_t)(e->n + i + 1);
            column[nnz + at] = (MUMPS_INT)(e->b.index[at] += 1);
            value[nnz + at] = e->b.value[at];
        }
    e->mumps.n = (MUMPS_INT)(e->n + e->b.lines);
    e->mumps.nnz = (MUMPS_INT8)all;
    e->mumps.irn = (MUMPS_INT *)row;
    e->mumps.a = value;
    return true;
}

/* PERM_IN holds the position of each unknown, counted from 1, the multipliers last. False: not a permutation. */
static bool give_order(Engine *e, const uint32_t *order)
{
    MUMPS_INT *position = e->mumps.perm_in;
    for (uint64_t k = 0; k < e->n; k++) {
        if (order[k] >= e->n || position[order[k]] != 0)
            return false;
        position[order[k]] = (MUMPS_INT)(k + 1);
    }
    e->mumps.size_schur = (MUMPS_INT)e->b.lines;
    for (uint64_t i = 0; i < e->b.lines; i++)
        position[e->n + i] = e->mumps.listvar_schur[i] = (MUMPS_INT)(e->n + i + 1);
    return true;
}

static bool workspace_too_small(const Engine *e)
{
    int code = e->INFOG(1);
    return code == -8 || code == -9 || code == -17 || code == -20;
}

static Status make_factor(Engine *e)
{
    Status status = run(e, JOB_ANALYSE);
    if (status != DONE)
        return status;
    status = run(e, JOB_FACTORISE);
    while (workspace_too_small(e) && e->ICNTL(14) < MOST_RELAXATION) {
        e->ICNTL(14) = 2 * e->ICNTL(14) + 10;
        status = run(e, JOB_FACTORISE);
    }
    /* MUMPS goes on past a negative pivot and counts it; beside a Schur complement it also lifts pivots of less than
     * 1.2e-7 to that, and counts those. */
    return status == DONE && (e->INFOG(12) > 0 || e->INFOG(25) > 0) ? NOT_POSITIVE : status;
}

/* As compressed. MUMPS counts in millions, as a negative number, what is too much for its integers. */
static uint64_t factor_entries(const Engine *e)
{
    int64_t count = e->INFOG(35);
    return (uint64_t)(count < 0 ? -1000000 * count : count);
}

/* Of a symmetric Schur complement, MUMPS gives the lower triangle, by rows. */
static void answer_factor(Engine *e)
{
    size_t m = e->b.lines;
    float *s = e->mumps.schur;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j <= i; j++)
            s[j * m + i] = s[i * m + j] = -s[i * m + j];
    put_u64(DONE);
    put_u64(factor_entries(e));
    put_u64(UINT64_C(1000000) * (uint64_t)e->INFOG(18));
    put_u64(UINT64_C(1000000) * (uint64_t)e->INFOG(19));
    put(s, m * m * sizeof *s);
}

static void factorise_system(Engine *e, Sparse *a, const uint32_t *order)
{
    size_t m = e->b.lines;
    e->begun = true;
    Status status = run(e, JOB_BEGIN);
    if (status != DONE) {
        answer_failure(e, status);
        return;
    }
    set_options(e);
    e->mumps.perm_in = calloc(e->n + m, sizeof(MUMPS_INT));
    e->mumps.listvar_schur = new_array(m, sizeof(MUMPS_INT));
    e->mumps.schur = new_array(m * m, sizeof(float));
    if (!give_entries(e, a) || !e->mumps.perm_in || !e->mumps.listvar_schur || !e->mumps.schur)
        answer_text(NO_MEMORY, "no memory on process 0 for the matrix and S");
    else if (!give_order(e, order))
        answer_text(OTHER, "the order is not a permutation of the unknowns");
    else if ((status = make_factor(e)) != DONE)
        answer_failure(e, status);
    else {
        answer_factor(e);
        e->ready = true;
    }
    free(e->mumps.jcn);
    free(e->mumps.perm_in);
    free(e->mumps.listvar_schur);
    free(e->mumps.schur);
}

static void factorise(Engine *e)
{
    forget(e);
    e->n = get_u64();
    uint64_t nnz = get_u64(), m = get_u64(), nnz_b = get_u64();
    Sparse a = get_sparse(e->n, nnz);
    uint32_t *order = get_array(e->n, sizeof *order);
    e->b = get_sparse(m, nnz_b);
    const char *fault;
    if (!fits(&a) || !order || !fits(&e->b))
        answer_text(NO_MEMORY, "no memory on process 0 for the request");
    else if ((fault = fault_of_system(&a, &e->b)))
        answer_text(OTHER, fault);
    else
        factorise_system(e, &a, order);
    free_sparse(&a);
    free(order);
}

/* ---- SOLVE and COMPLIANCE ---- */

/* x has room for `count` columns of mumps.n numbers; unless `sparse`, they are the right-hand sides on entry. */
static Status solve_columns(Engine *e, float *x, uint64_t count, bool sparse)
{
    e->ICNTL(20) = sparse;
    e->ICNTL(27) = BLOCK;
    e->mumps.rhs = x;
    e->mumps.nrhs = (MUMPS_INT)count;
    e->mumps.lrhs = e->mumps.n;
    return run(e, JOB_SOLVE);
}

static void solve(Engine *e)
{
    uint64_t count = get_u64();
    size_t length = size_of(e->n, sizeof(float)), stride = e->n + e->b.lines;
    float *x = e->ready ? calloc(size_of(count, stride), sizeof *x) : NULL;
    for (uint64_t i = 0; i < count && length > 0; i++)
        get_or_skip(x ? x + i * stride : NULL, length);
    Status status;
    if (!e->ready)
        answer_text(OTHER, "there is no factor");
    else if (count == 0 || count > INT_MAX)
        answer_text(OTHER, "the number of right-hand sides is not between 1 and 2^31 - 1");
    else if (!x)
        answer_text(NO_MEMORY, "no memory on process 0 for right-hand sides");
    else if ((status = solve_columns(e, x, count, false)) != DONE)
        answer_failure(e, status);
    else {
        put_u64(DONE);
        for (uint64_t i = 0; i < count; i++)
            put(x + i * stride, length);
    }
    free(x);
}

/* The right-hand sides are the rows `first`, `first` + 1, ... of B. */
static Status solve_rows(Engine *e, float *x, uint64_t first, uint64_t count)
{
    MUMPS_INT start[BLOCK + 1];
    uint64_t from = e->b.start[first];
    for (uint64_t i = 0; i <= count; i++)
        start[i] = (MUMPS_INT)(e->b.start[first + i] - from + 1);
    e->mumps.irhs_ptr = start;
    e->mumps.irhs_sparse = (MUMPS_INT *)e->b.index + from;
    e->mumps.rhs_sparse = e->b.value + from;
    e->mumps.nz_rhs = start[count] - 1;
    return solve_columns(e, x, count, true);
}

/* out = C x. */
static void multiply(const Sparse *c, const float *x, float *out)
{
    for (uint64_t i = 0; i < c->lines; i++) {
        double sum = 0;
        for (uint64_t at = c->start[i]; at < c->start[i + 1]; at++)
            sum += (double)c->value[at] * x[c->index[at]];
        out[i] = (float)sum;
    }
}

static Status fill_compliance(Engine *e, const Sparse *c, float *x, float *g)
{
    for (uint64_t first = 0, count; first < e->b.lines; first += count) {
        count = e->b.lines - first < BLOCK ? e->b.lines - first : BLOCK;
        Status status = solve_rows(e, x, first, count);
        if (status != DONE)
            return status;
        for (uint64_t i = 0; i < count; i++)
            multiply(c, x + i * (size_t)e->mumps.n, g + (first + i) * c->lines);
    }
    return DONE;
}

static void answer_compliance(Engine *e, const Sparse *c)
{
    uint64_t numbers = size_of(e->b.lines, c->lines);
    float *g = new_array(numbers, sizeof *g);
    float *x = new_array((uint64_t)BLOCK * (uint64_t)e->mumps.n, sizeof *x);
    Status status;
    if (!g || !x)
        answer_text(NO_MEMORY, "no memory on process 0 for the compliance");
    else if ((status = fill_compliance(e, c, x, g)) != DONE)
        answer_failure(e, status);
    else {
        put_u64(DONE);
        put(g, numbers * sizeof *g);
    }
    free(g);
    free(x);
}

static void compliance(Engine *e)
{
    uint64_t lines = get_u64(), entries = get_u64();
    Sparse c = get_sparse(lines, entries);
    const char *fault;
    if (!e->ready)
        answer_text(OTHER, "there is no factor");
    else if (!fits(&c))
        answer_text(NO_MEMORY, "no memory on process 0 for the request");
    else if ((fault = fault_of_sparse(&c, e->n)))
        answer_text(OTHER, fault);
    else
        answer_compliance(e, &c);
    free_sparse(&c);
}

/* ---- the program ---- */

static void greet(const Engine *e)
{
    char name[160], rank[48] = "";
    if (e->low_rank >= 0)
        snprintf(rank, sizeof rank, ", block low-rank %g", e->low_rank);
    snprintf(name, sizeof name, "MUMPS %s, single precision, %d process%s%s", MUMPS_VERSION, e->processes,
             e->processes == 1 ? "" : "es", rank);
    put("C3DENG01", 8);
    put_u64(strlen(name));
    put(name, strlen(name));
    fflush(stdout);
}

/* False at the end of the input, or when asked to leave. */
static bool answer_request(Engine *e)
{
    uint64_t request;
    size_t got = fread(&request, 1, sizeof request, stdin);
    if (got == 0)
        return false;
    if (got < sizeof request)
        stop("standard input ended inside a request");
    switch (request) {
    case LEAVE: return false;
    case FACTORISE: factorise(e); break;
    case SOLVE: solve(e); break;
    case COMPLIANCE: compliance(e); break;
    default: stop("an unknown request");
    }
    if (fflush(stdout) != 0)
        stop("standard output is closed");
    return true;
}

static void serve(Engine *e)
{
    greet(e);
    while (answer_request(e))
        continue;
    forget(e);
    share_job(NO_JOB);
}

static const char USAGE[] =
    "usage: mpirun -n PROCESSES contact3d-mumps [--low-rank EPS]\n"
    "\n"
    "A linear engine for contact3d-pipe, which starts it and speaks with it through standard input and output.\n"
    "\n"
    "  --low-rank EPS   compress blocks of the factor to low rank, dropping what is below EPS (0 < EPS < 1);\n"
    "                   the matrix has a unit diagonal\n"
    "  --help           print this\n";

static bool read_tolerance(Engine *e, const char *word)
{
    char *end;
    e->low_rank = strtod(word, &end);
    return end != word && *end == '\0' && e->low_rank > 0 && e->low_rank < 1;
}

/* What is wrong with the arguments, or "". */
static const char *read_arguments(Engine *e, int count, char **words, bool *help)
{
    e->low_rank = -1;
    for (int i = 1; i < count; i++)
        if (strcmp(words[i], "--help") == 0)
            *help = true;
        else if (strcmp(words[i], "--low-rank") != 0)
            return words[i];
        else if (++i == count || !read_tolerance(e, words[i]))
            return "--low-rank without a number between 0 and 1";
    return "";
}

int main(int count, char **words)
{
    static Engine engine;
    int rank;
    bool help = false;
    MPI_Init(&count, &words);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &engine.processes);
    const char *wrong = read_arguments(&engine, count, words, &help);
    if (*wrong && rank == 0)
        fprintf(stderr, "contact3d-mumps: bad argument: %s\n%s", wrong, USAGE);
    else if (help && rank == 0)
        fputs(USAGE, stdout);
    else if (!*wrong && !help && rank == 0)
        serve(&engine);
    else if (!*wrong && !help)
        help_process_0(&engine);
    MPI_Finalize();
    return *wrong ? 2 : 0;
}
