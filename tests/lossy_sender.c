/* Preloaded into a process, loses every n-th datagram that it sends to another one's topics: n
is in the environment, as LOSES_EVERY.

Compiled by conftest.py. Those for discovery go to even ports, and all pass. */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/socket.h>

static atomic_uint sent;

static int is_lost(const struct sockaddr *to) {
  const struct sockaddr_in *address = (const struct sockaddr_in *)to;
  return to && to->sa_family == AF_INET && ntohs(address->sin_port) % 2 && ++sent % atoi(getenv("LOSES_EVERY")) == 0;
}

ssize_t sendto(int fd, const void *data, size_t size, int flags, const struct sockaddr *to,
               socklen_t length) {
  ssize_t (*real)(int, const void *, size_t, int, const struct sockaddr *, socklen_t) =
      dlsym(RTLD_NEXT, "sendto");
  return is_lost(to) ? (ssize_t)size : real(fd, data, size, flags, to, length);
}

ssize_t sendmsg(int fd, const struct msghdr *message, int flags) {
  ssize_t (*real)(int, const struct msghdr *, int) = dlsym(RTLD_NEXT, "sendmsg");
  if (!is_lost(message->msg_name)) return real(fd, message, flags);
  ssize_t size = 0;
  for (size_t i = 0; i < message->msg_iovlen; i++) size += message->msg_iov[i].iov_len;
  return size;
}
