"""The demonstrator's console in the browser, over the public topics and services of a swarm."""
