"""Shapes to compare methods on: embedded, downloaded, generated, or any file."""

from lpcompare.models.catalogue import load_model, model_names, model_summary

__all__ = ["load_model", "model_names", "model_summary"]
