"""Behaviors as files: folders, editions, bundles, trimming, differences."""
