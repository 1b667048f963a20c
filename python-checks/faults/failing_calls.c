/* System calls that fail on purpose, for a program started with LD_PRELOAD.
 *
 * Settings, all from the environment:
 *   FAULT_CALL     write, sync, rename, truncate, unlink, mkdir, chmod, link or close
 *   FAULT_FROM     the first of these calls that fails, counted from 1
 *   FAULT_UNTIL    the last one
 *   FAULT_PERCENT  of the calls between them fail, chosen by FAULT_SEED
 *   FAULT_HOW      error: the call does nothing and sets errno to FAULT_ERRNO
 *                  short: a write takes half of its bytes, as writes may
 *                  lose:  a write claims to have been done
 *   FAULT_COUNTS   a file that gets the number of calls of each kind when the program ends
 *   FAULT_CLOCK    what the clock shows, in seconds since 1970
 *
 * Only calls on regular files and folders count, so neither pipes nor terminals ever fail.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum kind { WRITE, SYNC, RENAME, TRUNCATE, UNLINK, MKDIR, CHMOD, LINK, CLOSE, KINDS };
static const char *const names[KINDS] = {"write", "sync",  "rename", "truncate", "unlink",
                                         "mkdir", "chmod", "link",   "close"};
enum how { NO, ERROR, SHORT, LOSE };

static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER;
static long seen[KINDS];
static unsigned long long chance;

static long number(const char *name, long otherwise)
{
    const char *text = getenv(name);
    return text ? atol(text) : otherwise;
}

/* splitmix64 */
static unsigned long long next_random(void)
{
    if (chance == 0)
        chance = (unsigned long long)number("FAULT_SEED", 1);
    unsigned long long z = chance += 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

/* Counts a call and decides about it. */
static enum how decide(enum kind kind)
{
    const char *chosen = getenv("FAULT_CALL");
    const char *how = getenv("FAULT_HOW");
    enum how decided = NO;
    pthread_mutex_lock(&turn);
    long count = ++seen[kind];
    if (chosen && !strcmp(chosen, names[kind]) && count >= number("FAULT_FROM", 1) &&
        count <= number("FAULT_UNTIL", count) &&
        (long)(next_random() % 100) < number("FAULT_PERCENT", 100))
        decided = how && !strcmp(how, "short") ? SHORT : how && !strcmp(how, "lose") ? LOSE : ERROR;
    pthread_mutex_unlock(&turn);
    if (decided == ERROR)
        errno = (int)number("FAULT_ERRNO", EIO);
    return decided;
}

static int counts(int fd)
{
    struct stat about;
    int kept = errno;
    int is_file = fstat(fd, &about) == 0 && (S_ISREG(about.st_mode) || S_ISDIR(about.st_mode));
    errno = kept;
    return is_file;
}

#define REAL(name)                                                                                 \
    static __typeof__(name) *real;                                                                 \
    if (!real)                                                                                     \
    real = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

#define WRITING(call, shorter)                                                                     \
    switch (counts(fd) ? decide(WRITE) : NO) {                                                     \
    case ERROR:                                                                                    \
        return -1;                                                                                 \
    case LOSE:                                                                                     \
        return (ssize_t)size;                                                                      \
    case SHORT:                                                                                    \
        return shorter;                                                                            \
    default:                                                                                       \
        return call;                                                                               \
    }
#define HALF (size - size / 2)

ssize_t write(int fd, const void *bytes, size_t size)
{
    REAL(write);
    WRITING(real(fd, bytes, size), real(fd, bytes, HALF))
}

ssize_t pwrite(int fd, const void *bytes, size_t size, off_t at)
{
    REAL(pwrite);
    WRITING(real(fd, bytes, size, at), real(fd, bytes, HALF, at))
}

ssize_t pwrite64(int fd, const void *bytes, size_t size, off64_t at)
{
    REAL(pwrite64);
    WRITING(real(fd, bytes, size, at), real(fd, bytes, HALF, at))
}

/* Copies inside the kernel: refused, so that programs copy by reads and writes. */
ssize_t copy_file_range(int from, off64_t *at, int to, off64_t *there, size_t size, unsigned flags)
{
    (void)from, (void)at, (void)to, (void)there, (void)size, (void)flags;
    errno = ENOSYS;
    return -1;
}

ssize_t sendfile64(int to, int from, off64_t *at, size_t size)
{
    (void)to, (void)from, (void)at, (void)size;
    errno = ENOSYS;
    return -1;
}

#define PLAIN(kind, call) return decide(kind) == ERROR ? -1 : call

int fsync(int fd)
{
    REAL(fsync);
    PLAIN(SYNC, real(fd));
}

int fdatasync(int fd)
{
    REAL(fdatasync);
    PLAIN(SYNC, real(fd));
}

int rename(const char *from, const char *to)
{
    REAL(rename);
    PLAIN(RENAME, real(from, to));
}

int ftruncate(int fd, off_t size)
{
    REAL(ftruncate);
    PLAIN(TRUNCATE, real(fd, size));
}

int ftruncate64(int fd, off64_t size)
{
    REAL(ftruncate64);
    PLAIN(TRUNCATE, real(fd, size));
}

int unlink(const char *path)
{
    REAL(unlink);
    PLAIN(UNLINK, real(path));
}

int mkdir(const char *path, mode_t mode)
{
    REAL(mkdir);
    PLAIN(MKDIR, real(path, mode));
}

int chmod(const char *path, mode_t mode)
{
    REAL(chmod);
    PLAIN(CHMOD, real(path, mode));
}

int fchmod(int fd, mode_t mode)
{
    REAL(fchmod);
    PLAIN(CHMOD, real(fd, mode));
}

int linkat(int from, const char *old, int to, const char *new, int flags)
{
    REAL(linkat);
    PLAIN(LINK, real(from, old, to, new, flags));
}

/* The descriptor is gone even where closing fails. */
int close(int fd)
{
    REAL(close);
    if (!counts(fd) || decide(CLOSE) != ERROR)
        return real(fd);
    int failed = errno;
    real(fd);
    errno = failed;
    return -1;
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    REAL(clock_gettime);
    int result = real(clock, time);
    if (clock == CLOCK_REALTIME)
        time->tv_sec = number("FAULT_CLOCK", time->tv_sec);
    return result;
}

__attribute__((destructor)) static void tell(void)
{
    const char *path = getenv("FAULT_COUNTS");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file)
        return;
    for (int kind = 0; kind < KINDS; kind++)
        fprintf(file, "%s %ld\n", names[kind], seen[kind]);
    fclose(file);
}
