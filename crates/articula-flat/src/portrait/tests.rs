//! Tests of whole portraits.
